/// The pages of the project: short paragraphs, links that lead somewhere, and names of tests, pages and headings that exist.

#include "command.h"

#include <map>
#include <regex>
#include <set>

using namespace taut::test;

namespace {

constexpr std::size_t kMostWords = 80;

struct Paragraph {
    std::size_t line = 0; ///< of the page, from 1
    std::string text;
};

/// A page of Markdown, taken apart. Code (fenced, or indented by four) is in none of it.
struct Page {
    std::vector<Paragraph> paragraphs; ///< a list item counts as its own
    std::string prose;                 ///< all but code: paragraphs, headings, tables
    std::vector<std::string> headings;
};

std::string trimmed(const std::string &line) {
    const std::size_t begin = line.find_first_not_of(" \t");
    return begin == std::string::npos ? "" : line.substr(begin, line.find_last_not_of(" \t\r") - begin + 1);
}

bool startsItem(const std::string &text) {
    static const std::regex kItem(R"(([-*+]|\d+[.)])\s.*)");
    return std::regex_match(text, kItem);
}

/// The text of a heading, "" of any other line.
std::string headingOf(const std::string &line) {
    static const std::regex kHeading(R"(#{1,6} +(.*\S)\s*)");
    std::smatch match;
    return std::regex_match(line, match, kHeading) ? match[1].str() : "";
}

Page pageOf(const std::string &markdown) {
    Page page;
    bool fenced = false;
    bool inList = false;
    bool open = false; // the last paragraph goes on
    std::size_t number = 0;
    for (const std::string &line : linesOf(markdown)) {
        ++number;
        const std::string text = trimmed(line);
        const bool fence = text.rfind("```", 0) == 0 || text.rfind("~~~", 0) == 0;
        if (fence) fenced = !fenced;
        const std::string heading = fenced ? "" : headingOf(line);
        const bool indented = line.rfind("    ", 0) == 0 && !inList && !open;
        const bool table = text.rfind('|', 0) == 0;
        if (fenced || fence || text.empty() || indented || table || !heading.empty()) {
            open = false;
            if (!heading.empty()) page.headings.push_back(heading);
            if (!text.empty()) inList = inList && !table && heading.empty();
            if (!fenced && !fence && !indented) page.prose += line + "\n";
            continue;
        }
        page.prose += line + "\n";
        if (startsItem(text)) {
            open = false;
            inList = true;
        } else if (!open && line.front() != ' ') {
            inList = false;
        }
        if (!open) page.paragraphs.push_back({number, ""});
        open = true;
        page.paragraphs.back().text += text + " ";
    }
    return page;
}

std::size_t wordsIn(const std::string &text) {
    std::istringstream words(text);
    return static_cast<std::size_t>(std::distance(std::istream_iterator<std::string>(words), {}));
}

/// The lines where paragraphs begin that are too long.
std::vector<std::size_t> longParagraphs(const Page &page) {
    std::vector<std::size_t> lines;
    for (const Paragraph &paragraph : page.paragraphs)
        if (wordsIn(paragraph.text) > kMostWords) lines.push_back(paragraph.line);
    return lines;
}

/// What GitHub makes of headings: lower case, spaces as hyphens, most punctuation left out, repeated ones numbered.
std::set<std::string> anchorsOf(const Page &page) {
    std::set<std::string> anchors;
    std::map<std::string, int> seen;
    for (const std::string &heading : page.headings) {
        std::string anchor;
        for (const unsigned char c : heading) {
            if (c == ' ') anchor += '-';
            if (std::isalnum(c) != 0 || c == '-' || c == '_' || c >= 0x80) anchor += static_cast<char>(std::tolower(c));
        }
        const int before = seen[anchor]++;
        anchors.insert(before == 0 ? anchor : anchor + "-" + std::to_string(before));
    }
    return anchors;
}

/// All first groups of a pattern in a text.
std::vector<std::string> matchesIn(const std::string &text, const std::regex &pattern) {
    std::vector<std::string> found;
    for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) found.push_back((*it)[1]);
    return found;
}

/// The links of a page that lead to files.
std::vector<std::string> linksOf(const Page &page) {
    static const std::regex kLink(R"(\]\((?!https?:)([^)\s]+)\))");
    return matchesIn(page.prose, kLink);
}

/// The file that a link on a page leads to.
fs::path targetOf(const std::string &link, const fs::path &file) {
    const std::string path = link.substr(0, link.find('#'));
    return path.empty() ? file : fs::weakly_canonical(file.parent_path() / path);
}

/// Links of a page that lead nowhere: files that are not there, headings that the file does not have.
std::vector<std::string> brokenLinks(const Page &page, const fs::path &file) {
    std::vector<std::string> broken;
    for (const std::string &link : linksOf(page)) {
        const std::size_t hash = std::min(link.find('#'), link.size());
        const fs::path target = targetOf(link, file);
        const bool leads =
            fs::exists(target) && (hash == link.size() || anchorsOf(pageOf(readBytes(target.string()))).count(link.substr(hash + 1)) == 1);
        if (!leads) broken.push_back(link);
    }
    return broken;
}

/// README.md and every other page of the project.
std::vector<std::string> pages() {
    std::vector<std::string> names{"README.md"};
    for (const std::string folder : {"docs", "meshes"})
        for (const std::string &name : namesIn(std::string(TAUT_SOURCE_DIR) + "/" + folder))
            if (fs::path(name).extension() == ".md") names.push_back(folder + "/" + name);
    return names;
}

Page readPage(const std::string &name) {
    return pageOf(readBytes(std::string(TAUT_SOURCE_DIR) + "/" + name));
}

/// The texts of all sources below these folders, one after the other.
std::string sourcesOf(const std::vector<std::string> &folders) {
    std::string all;
    for (const std::string &folder : folders)
        for (const auto &entry : fs::recursive_directory_iterator(fs::path(TAUT_SOURCE_DIR) / folder)) {
            const fs::path &path = entry.path();
            if (path.extension() == ".h" || path.extension() == ".cpp" || path.extension() == ".py") all += readBytes(path.string());
        }
    return all;
}

/// Comments that begin by naming nothing: they say as little in a tooltip.
std::vector<std::string> namelessComments(const std::string &source) {
    static const std::regex kComment(R"(///?<? (The same\b[^\n]*))");
    return matchesIn(source, kComment);
}

std::string repeated(const std::string &word, std::size_t times) {
    std::string text;
    for (std::size_t i = 0; i < times; ++i) text += word + (i % 10 == 9 ? "\n" : " ");
    return text;
}

} // namespace

TEST_CASE("prose: the checker finds what it is for", "[prose]") {
    using Lines = std::vector<std::size_t>;
    const std::string fits = repeated("word", 80);
    const std::string tooLong = repeated("word", 81);
    CHECK(longParagraphs(pageOf("# A page\n\n" + fits + "\n\n" + fits)).empty());
    CHECK(longParagraphs(pageOf("# A page\n" + tooLong)) == Lines{2});
    CHECK(longParagraphs(pageOf("Short.\n\n> " + tooLong)) == Lines{3});
    // Each item of a list is a paragraph of its own; what is indented below one belongs to the list.
    CHECK(longParagraphs(pageOf("- " + repeated("word", 70) + "\n- " + repeated("word", 70) + "\n1. " + repeated("word", 70))).empty());
    CHECK(longParagraphs(pageOf("- short\n- " + tooLong)) == Lines{2});
    CHECK(longParagraphs(pageOf("- short\n\n    " + tooLong)) == Lines{3});
    // Code and tables are left out, and end a paragraph.
    CHECK(longParagraphs(pageOf("```\n" + tooLong + "\n```\n\n| " + repeated("word", 9) + " |\n")).empty());
    CHECK(longParagraphs(pageOf("Code:\n\n    " + repeated("x", 9) + "\n    " + repeated("x", 9))).empty());
    CHECK(longParagraphs(pageOf("```sh\ncode\n```\n" + tooLong)) == Lines{4});

    const fs::path here = fs::path(freshFolder("prose")) / "page.md";
    const std::string bad = "# Results, twice\n## Twice\n## Twice\n[a](nowhere.md) [b](other.md#b) [c](#results-twice) [d](#twice-1)\n"
                            "[e](#twice-2) | [f](https://example.org/x) `code`\n```\n[g](inside/code.md)\n```\n"
                            "| [h](other.md#the-mesh-a_b) | [i](missing/) |\n";
    writeBytes(here.string(), bad);
    writeBytes((here.parent_path() / "other.md").string(), "## The [mesh], `a_b`!\n");
    CHECK(brokenLinks(pageOf(bad), here) == Arguments{"nowhere.md", "other.md#b", "#twice-2", "missing/"});
}

TEST_CASE("prose: no paragraph is longer than eighty words", "[prose]") {
    for (const std::string &name : pages())
        for (const std::size_t line : longParagraphs(readPage(name))) FAIL_CHECK(name << ":" << line);
}

TEST_CASE("prose: every link leads to a file, and to a heading where it names one", "[prose]") {
    CHECK(pages().size() > 10);
    for (const std::string &name : pages())
        for (const std::string &link : brokenLinks(readPage(name), fs::path(TAUT_SOURCE_DIR) / name)) FAIL_CHECK(name << " -> " << link);
}

TEST_CASE("prose: every page can be reached from the README", "[prose]") {
    const fs::path root = fs::canonical(TAUT_SOURCE_DIR);
    std::set<fs::path> reached{root / "README.md"};
    for (std::vector<fs::path> waiting(reached.begin(), reached.end()); !waiting.empty();) {
        const fs::path file = waiting.back();
        waiting.pop_back();
        for (const std::string &link : linksOf(pageOf(readBytes(file.string())))) {
            const fs::path target = targetOf(link, file);
            if (target.extension() == ".md" && reached.insert(target).second) waiting.push_back(target);
        }
    }
    for (const std::string &name : pages())
        if (reached.count(root / name) == 0) FAIL_CHECK("no way leads to " << name);
}

TEST_CASE("prose: tests that pages name exist", "[prose]") {
    static const std::regex kTags(R"re("~?((?:\[[a-z_0-9]+\]~?)+)")re");
    static const std::regex kTag(R"(\[([a-z_0-9]+)\])");
    const std::string tests = sourcesOf({"tests"});
    std::size_t named = 0;
    for (const std::string &name : pages())
        for (const std::string &tags : matchesIn(readPage(name).prose, kTags))
            for (const std::string &tag : matchesIn(tags, kTag)) {
                ++named;
                if (tests.find("[" + tag + "]") == std::string::npos) FAIL_CHECK(name << " names tests [" << tag << "]");
            }
    CHECK(named > 20);
}

TEST_CASE("prose: a comment says what a thing does, not that it does the same", "[prose]") {
    CHECK(namelessComments(std::string("int a; /") + "/ The same in double.\n/// What is The same\n/" + "// The samemost\n").size() == 1);
    for (const std::string &comment : namelessComments(sourcesOf({"src", "apps", "tests"}))) FAIL_CHECK(comment);
}

TEST_CASE("prose: pages and headings that comments name exist", "[prose]") {
    static const std::regex kPage(R"((docs/[a-z_]+\.md))");
    static const std::regex kHeading(R"re((docs/[a-z_]+\.md, "[^"]+"))re");
    // A comment may break a line anywhere.
    const std::string sources = std::regex_replace(sourcesOf({"src", "apps"}), std::regex(R"(\n\s*(///?|#) ?)"), " ");
    CHECK(matchesIn(sources, kPage).size() > 10);
    for (const std::string &page : matchesIn(sources, kPage))
        if (!fs::exists(fs::path(TAUT_SOURCE_DIR) / page)) FAIL_CHECK("a comment names " << page);
    for (const std::string &both : matchesIn(sources, kHeading)) {
        const std::size_t comma = both.find(", \"");
        const std::vector<std::string> headings = readPage(both.substr(0, comma)).headings;
        const std::string heading = both.substr(comma + 3, both.size() - comma - 4);
        if (std::find(headings.begin(), headings.end(), heading) == headings.end()) FAIL_CHECK("a comment names " << both);
    }
}
