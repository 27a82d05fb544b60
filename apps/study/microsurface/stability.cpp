#include "study/microsurface/stability.h"

#include "study/text.h"

#include "taut/base/error.h"

#include <sstream>

namespace taut::chart {

namespace {

using precision::Sample;

constexpr std::size_t kColumns = 10;
constexpr const char *kWrong = "wrong";
constexpr const char *kNotFinite = "not finite";

std::string numbers(const char *format, std::initializer_list<double> values) {
    std::string text;
    for (const double value : values)
        text += (text.empty() ? "" : " ") + (std::isnan(value) ? "nan" : printed(format, value)); // whatever its sign
    return text;
}

/// "1 2 3" -> {1, 2, 3}.
std::vector<double> numbersIn(const std::string &text, std::size_t count) {
    std::vector<double> values;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        char *end = nullptr;
        values.push_back(std::strtod(word.c_str(), &end));
        if (*end != '\0') failInput({"stability"}, quoted(std::string_view(word)), "a number");
    }
    if (values.size() != count) failInput({"stability"}, quoted(text), std::to_string(count) + " numbers");
    return values;
}

Vec3 vectorIn(const std::string &text) {
    const auto v = numbersIn(text, 3);
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

std::vector<std::string> cellsOf(const std::string &line) {
    std::vector<std::string> cells;
    for (std::size_t at = line.find('|'); at != std::string::npos;) {
        const std::size_t end = line.find('|', at + 1);
        if (end == std::string::npos) break;
        const std::string cell = line.substr(at + 1, end - at - 1);
        const std::size_t first = cell.find_first_not_of(' ');
        cells.push_back(first == std::string::npos ? "" : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
        at = end;
    }
    return cells;
}

std::string formulationName(std::size_t formulation) {
    static const precision::Sweep<float> kNames;
    return kNames.formulations()[formulation].name;
}

} // namespace

Region::Region(const std::string &words) {
    std::istringstream stream(words);
    const std::pair<const char *, Feature> features[] = {
        {"min", Feature::Least}, {"max", Feature::Greatest}, {"max/min", Feature::Ratio}, {"view", Feature::View}};
    for (std::string name, comparison, bound, join; stream >> name >> comparison >> bound;) {
        const auto *feature = std::find_if(std::begin(features), std::end(features), [&](const auto &f) { return name == f.first; });
        if (feature == std::end(features)) failInput({"region"}, quoted(std::string_view(name)), "min, max, max/min or view");
        if (comparison != "<=" && comparison != ">=") failInput({"region"}, quoted(std::string_view(comparison)), "<= or >=");
        conditions_.push_back({feature->second, comparison == ">=", numbersIn(bound, 1)[0]});
        if (stream >> join && join != "and") failInput({"region"}, quoted(std::string_view(join)), "and");
    }
    if (conditions_.empty()) failInput({"region"}, quoted(words), "a comparison such as 'min <= 0.01'");
}

bool Region::holds(const Sample &sample) const {
    const EquivalentAlpha alpha = equivalentAlpha(sample.m);
    for (const Condition &c : conditions_) {
        const double value = c.feature == Feature::Least      ? static_cast<double>(alpha.min)
                             : c.feature == Feature::Greatest ? static_cast<double>(alpha.max)
                             : c.feature == Feature::Ratio    ? static_cast<double>(alpha.max / alpha.min)
                                                              : std::acos(static_cast<double>(sample.wo.z)) * 180 / std::numbers::pi;
        if (c.atLeast ? value < c.bound : value > c.bound) return false;
    }
    return true;
}

StabilityRow evaluated(const StabilityRow &row) {
    StabilityRow found = row;
    const auto values = precision::detail::evaluate<float>(row.m, row.wo, row.wi);
    const std::size_t q = row.failure.quantity;
    found.theirs = static_cast<double>(values[row.failure.formulation][q]);
    found.ours = static_cast<double>(values[precision::kStable][q]);
    found.truth = static_cast<double>(precision::detail::truthAt<float>(row.m, row.wo, row.wi)[q]);
    return found;
}

namespace {

/// Every region: what the table is made of.
std::vector<Failure> knownFailures() {
    using namespace precision;
    constexpr std::size_t kD = 0;
    constexpr std::size_t kG1 = 1;
    constexpr std::size_t kPdf = 2;
    constexpr std::size_t kWeight = 3;
    std::vector<Failure> all;
    for (const std::size_t q : {kD, kPdf}) all.push_back({kTextbook, q, "max/min >= 9000", false});
    for (const std::size_t f : {kWalter, kCosineSquared})
        for (const std::size_t q : {kD, kPdf}) {
            all.push_back({f, q, "min <= 0.01", false});
            all.push_back({f, q, "max/min >= 9000 and view >= 89.9", false});
        }
    for (const std::size_t q : {kD, kPdf}) all.push_back({kCosineSquared, q, "min <= 0.0001", true});
    for (const std::size_t q : {kG1, kPdf, kWeight}) all.push_back({kCosineSquared, q, "max >= 4000", false});
    all.push_back({kCosineSquared, kWeight, "max >= 8000", true});
    for (const std::size_t q : {kD, kPdf}) all.push_back({kChain, q, "max/min >= 80000", false});
    all.push_back({kChain, kPdf, "view >= 89.9", false});
    for (std::size_t q = 0; q < kQuantities; ++q) {
        all.push_back({kTensor, q, "max/min >= 180", false});
        all.push_back({kTensor, q, "max/min >= 80000", true});
    }
    return all;
}

std::vector<StabilityRow> stabilityRows(const std::vector<precision::Formulation> &sweep) {
    std::vector<StabilityRow> rows;
    for (const Failure &failure : knownFailures()) {
        const Region region(failure.where);
        const Sample *best = nullptr;
        const auto milder = [](const Sample &a, const Sample &b) {
            const EquivalentAlpha x = equivalentAlpha(a.m);
            const EquivalentAlpha y = equivalentAlpha(b.m);
            const auto decade = [](const EquivalentAlpha &e) { return std::floor(std::log10(e.max / e.min) + 0.5F); };
            const auto usual = [](const EquivalentAlpha &e) { return std::fabs(std::log(e.max * e.min)); };
            return decade(x) != decade(y) ? decade(x) < decade(y) : usual(x) < usual(y);
        };
        const std::vector<Sample> &samples = sweep[failure.formulation].samples;
        double greatest = 0;
        for (const Sample &sample : samples) {
            const double error = sample.error[failure.quantity];
            if (region.holds(sample) && std::isfinite(error)) greatest = std::max(greatest, error);
        }
        for (const Sample &sample : samples) {
            const double error = sample.error[failure.quantity];
            const bool fails = failure.notFinite ? !std::isfinite(error) : std::isfinite(error) && error > std::min(0.1, greatest / 2);
            if (!fails || !region.holds(sample)) continue;
            if (best == nullptr || milder(sample, *best)) best = &sample;
        }
        if (best == nullptr) continue;
        rows.push_back(evaluated({failure, best->m, best->wo, best->wi}));
    }
    return rows;
}

} // namespace

std::vector<std::string> cellsOf(const StabilityRow &row) {
    const auto vector = [](const Vec3 &v) {
        return numbers("%.9g", {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)});
    };
    return {formulationName(row.failure.formulation),
            precision::kQuantityNames[row.failure.quantity],
            row.failure.where,
            row.failure.notFinite ? kNotFinite : kWrong,
            numbers("%.9g", {static_cast<double>(row.m.a), static_cast<double>(row.m.b), static_cast<double>(row.m.d)}),
            vector(row.wo),
            vector(row.wi),
            numbers("%.8g", {row.truth}),
            numbers("%.3g", {row.theirs}),
            numbers("%.8g", {row.ours})};
}

Table stabilityTable(const std::vector<precision::Formulation> &sweep) {
    Table table{"stability",
                "Where the published forms fail",
                {"method", "quantity", "where", "it is", "M: a b d", "wo", "wi", "truth", "it gives", "ours gives"},
                {}};
    for (const StabilityRow &row : stabilityRows(sweep)) table.rows.push_back(cellsOf(row));
    return table;
}

std::vector<StabilityRow> readStability(const std::string &text) {
    std::vector<StabilityRow> rows;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        const auto cells = cellsOf(line);
        if (cells.size() != kColumns || cells[0] == "method" || cells[0].rfind("---", 0) == 0) continue;
        StabilityRow row;
        Failure &failure = row.failure;
        while (failure.formulation < precision::kFormulations && cells[0] != formulationName(failure.formulation)) ++failure.formulation;
        while (failure.quantity < precision::kQuantities && cells[1] != precision::kQuantityNames[failure.quantity]) ++failure.quantity;
        if (failure.formulation == precision::kFormulations || failure.quantity == precision::kQuantities)
            failInput({"stability"}, quoted(std::string_view(line)), "a known method and quantity");
        row.failure.where = cells[2];
        row.failure.notFinite = cells[3] == kNotFinite;
        const auto m = numbersIn(cells[4], 3);
        row.m = canonicalTransform(m[0], m[1], m[2]);
        row.wo = vectorIn(cells[5]);
        row.wi = vectorIn(cells[6]);
        row.truth = numbersIn(cells[7], 1)[0];
        row.theirs = numbersIn(cells[8], 1)[0];
        row.ours = numbersIn(cells[9], 1)[0];
        rows.push_back(row);
    }
    return rows;
}

} // namespace taut::chart
