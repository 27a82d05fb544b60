/// taut view: the scene in a browser, refined while one turns it. Documented in docs/view.md.

#include "../commands.h"
#include "../image_arguments.h"
#include "../interruption.h"
#include "session.h"
#include "view_page.h"

#include "taut/base/file_bytes.h"
#include "taut/scene/toml_text.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>

extern char **environ; // NOLINT: POSIX wants this declaration from the user

namespace taut::app {

namespace {

using Json = nlohmann::json;

struct ViewArguments {
    SceneArguments scene;
    ModelArguments model;
    ImageArguments image;
    std::string host = "127.0.0.1";
    int port = 0;
    std::string tokenFile;
    bool noGround = false;
    bool noOpen = false;
};

HttpResponse failure(unsigned status, const std::string &line) {
    return {status, "application/json", Json{{"error", line}}.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

/// KEY=VALUE&... as they are: the page's own need no decoding.
std::map<std::string, std::string> queryOf(const std::string &text) {
    std::map<std::string, std::string> out;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('&', at), text.size());
        const std::size_t equals = std::min(text.find('=', at), end);
        out[text.substr(at, equals - at)] = text.substr(std::min(equals + 1, end), end - std::min(equals + 1, end));
        at = end + 1;
    }
    return out;
}

template <class T> T numberOf(const std::map<std::string, std::string> &query, const std::string &key) {
    const auto found = query.find(key);
    T value{};
    if (found == query.end()) failInput({key}, "nothing", "a number");
    const char *end = found->second.data() + found->second.size();
    const auto [stop, error] = std::from_chars(found->second.data(), end, value);
    if (error != std::errc() || stop != end) failInput({key}, quoted(found->second), "a number");
    return value;
}

/// What the page asks for, each by its path.
class ViewApi {
  public:
    ViewApi(ViewSession &session, std::function<void()> quit) : session_(session), quit_(std::move(quit)) {}

    void answer(const HttpRequest &request, const HttpReply &reply) {
        try {
            if (request.method == "GET" ? get(request, reply) : post(request, reply)) return;
            reply(failure(404, "found " + quoted(request.method + " " + request.path) + ", expected what the page has"));
        } catch (const InputError &error) {
            reply(failure(400, error.what()));
        } catch (const Json::exception &error) {
            reply(failure(400, InputError(error.what()).what()));
        } catch (const std::exception &error) {
            reply(failure(500, error.what()));
        }
    }

  private:
    bool get(const HttpRequest &request, const HttpReply &reply) {
        const std::string name = request.path.empty() ? "index.html" : request.path;
        for (const PageFile &file : pageFiles())
            if (file.name == name) return reply({200, std::string(file.type), std::string(file.text)}), true;
        const auto query = queryOf(request.query);
        if (request.path == "view") return reply({200, kPictureType, session_.viewOfScene()}), true;
        if (request.path == "state") return reply(json(session_.state())), true;
        if (request.path == "picture")
            return session_.picture(numberOf<int>(query, "follows") != 0, numberOf<std::uint32_t>(query, "after"), reply), true;
        if (request.path == "inspect") return session_.inspect(numberOf<double>(query, "x"), numberOf<double>(query, "y"), reply), true;
        return false;
    }

    bool post(const HttpRequest &request, const HttpReply &reply) {
        if (request.path == "quit") return reply(json({{"bye", true}})), quit_(), true;
        if (request.path != "change" && request.path != "save") return false;
        const Json body = Json::parse(request.body);
        if (request.path == "change") return reply(json(session_.change(body))), true;
        return session_.save(body.at("name").get<std::string>(), reply), true;
    }

    static HttpResponse json(const Json &value) {
        return {200, "application/json", value.dump(-1, ' ', false, Json::error_handler_t::replace)};
    }

    ViewSession &session_;
    std::function<void()> quit_;
};

/// The token of a file that only its owner reads; made where it is not there, so that a server that starts again has the address it had.
std::string tokenOf(const std::string &path) {
    if (path.empty()) return randomToken();
    if (!std::filesystem::exists(path)) {
        const std::string token = randomToken();
        const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL, S_IRUSR | S_IWUSR);
        if (file < 0 || write(file, token.data(), token.size()) != static_cast<ssize_t>(token.size()))
            throw RunError(path + ": can't be written");
        close(file);
        return token;
    }
    std::string token = readFileBytes(path);
    while (!token.empty() && (token.back() == '\n' || token.back() == '\r')) token.pop_back();
    const bool good = token.size() >= 16 && token.size() <= 128 && token.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
    if (!good) failInput({"--token-file"}, quoted(std::string_view(token)), "16 to 128 hexadecimal digits");
    return token;
}

/// Where there is a screen.
void openBrowser(const std::string &url) {
    if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
    std::string program = "xdg-open";
    std::string argument = url;
    char *argv[] = {program.data(), argument.data(), nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t process = 0;
    posix_spawnp(&process, argv[0], &actions, nullptr, argv, environ); // the address is printed, whatever becomes of this
    posix_spawn_file_actions_destroy(&actions);
}

/// What options say of [image], as overrides: so what is saved says it too.
void addOverrides(const ImageArguments &image, std::vector<std::string> &overrides) {
    if (image.exposure) overrides.push_back("image.exposure=" + formatNumber(*image.exposure));
    const std::string config = image.config.empty() ? "" : std::filesystem::absolute(image.config).string();
    for (const auto &[key, text] : {std::pair("view", image.view), std::pair("ocio", config), std::pair("display", image.display),
                                    std::pair("space", image.space), std::pair("look", image.look)}) {
        TomlValue value;
        value.kind = TomlValue::Kind::String;
        value.text = text;
        if (!text.empty()) overrides.push_back(std::string("image.") + key + "=" + tomlInline(value));
    }
}

int view(const ViewArguments &arguments) {
    if (arguments.model.error)
        failInput({"--error"}, "a view, whose pictures go on to the scene's samples", "--tolerance, for the models alone");
    const auto threads = limitThreads(arguments.scene.threads);
    HttpOptions options;
    options.host = arguments.host;
    options.port = static_cast<unsigned short>(arguments.port);
    options.token = tokenOf(arguments.tokenFile);
    ViewApi *api = nullptr;
    HttpServer server(options, [&](const HttpRequest &request, const HttpReply &reply) { api->answer(request, reply); });
    Warnings warnings;
    SceneArguments scene = arguments.scene;
    if (arguments.noGround) scene.overrides.emplace_back("render.ground=false");
    addOverrides(arguments.image, scene.overrides);
    ViewSession session(scene, arguments.model, warnings);
    printWarnings(warnings);
    ViewApi answers(session, [&] { server.stopSoon(); });
    api = &answers;
    if (!server.isLoopback())
        std::cerr << "taut: warning: --host " << arguments.host << ": others on this network who have the address can change and save"
                  << std::endl;
    const StopRequest request([&] { server.stop(); }); // who has the address may end it
    std::cout << server.url() << std::endl;
    if (!arguments.noOpen) openBrowser(server.url());
    server.run();
    return 0;
}

} // namespace

void addView(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<ViewArguments>();
    CLI::App *command = parent.add_subcommand("view", "Look at a scene in the browser while turning it");
    addSceneArguments(*command, arguments->scene);
    addModelArguments(*command, arguments->model);
    addViewArguments(*command, arguments->image);
    command->add_option("--port", arguments->port, "Of the page's address (default: one that is free)")->check(CLI::Range(0, 65535));
    command->add_option("--host", arguments->host, "Address to listen at (default: 127.0.0.1: this machine alone)");
    command->add_option("--token-file", arguments->tokenFile,
                        "File with the secret of the page's address, made if it is not there: with --port the address stays");
    command->add_flag("--no-ground", arguments->noGround, "A file without a scene stands on no ground: the mesh alone in the dim studio");
    command->add_flag("--no-open", arguments->noOpen, "Only print the address");
    command->callback([&run, arguments] { run = [arguments] { return view(*arguments); }; });
}

} // namespace taut::app
