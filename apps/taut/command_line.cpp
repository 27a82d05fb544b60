#include "command_line.h"

#include "interruption.h"

#include "taut/images/image_codec.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <string_view>
#include <vector>

namespace taut::app {

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;

int fail(int code, const char *what) {
    std::cerr << "taut: error: " << what << std::endl;
    return code;
}

std::vector<CLI::App *> commandsOf(CLI::App &app) {
    return app.get_subcommands([](const CLI::App *) { return true; });
}

/// An unknown subcommand is answered with the nearest one, as unknown keys are.
void checkSubcommand(CLI::App &app, int argc, char **argv) {
    const std::vector<CLI::App *> commands = commandsOf(app);
    if (commands.empty()) return;
    std::vector<std::string> names;
    for (const CLI::App *command : commands) names.push_back(command->get_name());
    if (argc < 2) {
        std::string list;
        for (const std::string &name : names) list += (list.empty() ? "" : name == names.back() ? " or " : ", ") + name;
        throw InputError("found no subcommand, expected " + list + " (see taut --help)");
    }
    if (argv[1][0] == '-') return;
    const auto found = std::find(names.begin(), names.end(), argv[1]);
    if (found == names.end()) failUnknownName({"subcommand"}, argv[1], std::vector<std::string_view>(names.begin(), names.end()));
    checkSubcommand(*commands[static_cast<std::size_t>(found - names.begin())], argc - 1, argv + 1);
}

/// So is an unknown option.
void checkExtras(const CLI::App &app) {
    for (const CLI::App *command : app.get_subcommands()) checkExtras(*command);
    std::vector<std::string> names;
    for (const CLI::Option *option : app.get_options())
        for (const std::string &name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string &extra : app.remaining())
        if (extra.size() > 1 && extra[0] == '-')
            failUnknownName({"option"}, extra.substr(0, extra.find('=')), std::vector<std::string_view>(names.begin(), names.end()));
}

int run(int argc, char **argv, const AddCommands &addCommands) {
    CLI::App app("Renders deforming meshes whose gloss follows the deformation.", "taut");
    app.set_version_flag("--version", "taut " TAUT_VERSION);
    app.require_subcommand(0, 1); // none at all is told below, so that an unknown one is named
    Run chosen;
    addCommands(app, chosen);
    try {
        checkSubcommand(app, argc, argv);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ExtrasError &) {
            checkExtras(app);
            throw;
        }
        if (!chosen) return fail(kBadInput, "found no subcommand (see taut --help)");
        const int code = chosen();
        std::cout.flush();
        if (!std::cout || std::fflush(stdout) != 0) return fail(kFailed, "standard output could not be written");
        return code;
    } catch (const CLI::ParseError &error) {
        if (error.get_exit_code() == 0) return app.exit(error); // --help, --version
        // An InputError is one line whatever was typed.
        return fail(kBadInput, InputError(std::string(error.what()) + " (see taut --help)").what());
    } catch (const InputError &error) {
        return fail(kBadInput, error.what());
    } catch (const std::bad_alloc &) {
        return fail(kFailed, "out of memory");
    } catch (const std::exception &error) {
        return fail(kFailed, error.what());
    }
}

} // namespace

int runCommandLine(int argc, char **argv, const AddCommands &addCommands) {
    endCleanlyWhenStopped();
    const int code = run(argc, argv, addCommands);
    awaitImageCodec();
    return code;
}

} // namespace taut::app
