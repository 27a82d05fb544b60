/// docs/stability.md holds what it says: its values, that it names every region in which a published form fails in float, and that the
/// forms that render are right there.

#include "command.h"
#include "study/microsurface/stability.h"

#include "taut/base/error.h"

using namespace taut;
using namespace taut::chart;
using namespace taut::precision;
using namespace taut::test;

namespace {

std::vector<StabilityRow> table() {
    return readStability(readBytes(std::string(TAUT_SOURCE_DIR) + "/docs/stability.md"));
}

} // namespace

TEST_CASE("stability: regions in words are read as they are meant", "[stability]") {
    Sample sample;
    sample.m = microTransformFromAlpha(0.5F, 0.005F);
    sample.wo = Vec3(std::sin(1.0F), 0, std::cos(1.0F)); // 57.3 degrees
    CHECK(Region("min <= 0.01").holds(sample));
    CHECK_FALSE(Region("min >= 0.01").holds(sample));
    CHECK(Region("max >= 0.4 and max <= 0.6").holds(sample));
    CHECK(Region("max/min >= 99 and view >= 57").holds(sample));
    CHECK_FALSE(Region("max/min >= 99 and view >= 58").holds(sample));
    CHECK_FALSE(Region("max/min >= 101 and view >= 57").holds(sample));
    for (const char *bad : {"", "alpha <= 1", "min < 1", "min <= one", "min <= 1 or max >= 2"}) CHECK_THROWS_AS(Region(bad), InputError);
}

TEST_CASE("stability: the values of the table are those that the code gives", "[stability]") {
    const std::vector<StabilityRow> rows = table();
    CHECK(rows.size() >= 25);
    for (const StabilityRow &row : rows) {
        INFO(cellsOf(row)[0] << ", " << cellsOf(row)[1] << ", " << row.failure.where);
        const StabilityRow now = evaluated(row);
        CHECK(now.truth == Approx(row.truth).epsilon(1e-7));
        CHECK(now.ours == Approx(row.ours).epsilon(1e-7));
        CHECK(std::fabs(now.ours - now.truth) <= 3e-5 * now.truth);
        if (row.failure.notFinite) {
            CHECK_FALSE(std::isfinite(now.theirs));
        } else {
            CHECK(now.theirs == Approx(row.theirs).epsilon(6e-3).margin(1e-30)); // three digits are printed
            CHECK(std::fabs(now.theirs - now.truth) > kFails * now.truth);
        }
        Sample sample;
        sample.m = row.m;
        sample.wo = row.wo;
        CHECK(Region(row.failure.where).holds(sample));
    }
}

TEST_CASE("stability: no published form fails outside the regions of the table, ours in none of them", "[stability]") {
    const std::vector<StabilityRow> rows = table();
    const std::vector<Formulation> all = sweep();
    std::size_t failures = 0;
    double ours = 0;
    for (std::size_t f = 0; f < kFormulations; ++f)
        for (std::size_t q = 0; q < kQuantities; ++q) {
            if (f == kStable || f == kRoundedInputs) continue;
            std::vector<Region> wrong;
            std::vector<Region> notFinite;
            for (const StabilityRow &row : rows)
                if (row.failure.formulation == f && row.failure.quantity == q)
                    (row.failure.notFinite ? notFinite : wrong).emplace_back(row.failure.where);
            const auto named = [](const std::vector<Region> &regions, const Sample &sample) {
                return std::any_of(regions.begin(), regions.end(), [&](const Region &region) { return region.holds(sample); });
            };
            std::size_t unnamed = 0;
            for (std::size_t i = 0; i < all[f].samples.size(); ++i) {
                const Sample &sample = all[f].samples[i];
                if (!(sample.error[q] > kFails)) continue;
                ++failures;
                ours = std::max(ours, all[kStable].samples[i].error[q]);
                if (!named(std::isfinite(sample.error[q]) ? wrong : notFinite, sample)) ++unnamed;
            }
            INFO(all[f].name << ", " << kQuantityNames[q]);
            CHECK(unnamed == 0);
            CHECK((wrong.empty() || notFinite.size() + wrong.size() <= 4)); // regions, not lists of points
        }
    CHECK(failures > 10000);
    CHECK(ours < 3e-5);
}
