#pragma once
/// What choices cost: times that were measured once, on one machine, so that a plan depends on the scene alone and never on a clock.
///
/// The machine: two cores of a server processor at 2.5 GHz with AVX-512 and much cache, GCC 12, Release. To measure again, draw the
/// charts that are named (`taut chart NAME`) on a quiet machine and read their CSV: decisions weigh ratios, so what matters is that all
/// of a question's costs come from one machine.
///
/// What they can do to a picture: very little. A question's choices stand in a fixed order, cheapest first, and the tolerance is one of
/// error, so most costs are printed and decide nothing. Two decisions weigh times: whether the compensation is offered beside the walk,
/// and what is done to BVHs, which changes rounding alone. `taut_tests "[plan][costs]"` halves and doubles each cost over the scenes of
/// `taut chart plan` and prints which choices change: the error stays within the tolerance whatever they are.

namespace taut {

/// Both cores together; chart `bvh` draws the same on one thread, where updates and rays take about twice as long. One run of it, with
/// quads (triangle_pairs.h). A build is one of medium quality.
struct BvhCosts {
    double refit = 10e-9;     ///< s a triangle
    double build = 75e-9;     ///< s a triangle, beyond a refit
    double ray = 78e-9;       ///< s a ray, all threads together
    double slowdown = 1.0;    ///< relative slowdown of rays per relative growth of the boxes, plots "mild" and "strong"
    double refittable = 0.15; ///< relative slowdown of rays through BVHs that can be refitted, when fresh
};

struct PlanCosts {
    // ns a hit, to have M from what a mesh holds: an early bench of sampling and surfaces. The nearest of today is chart
    // `interpolation`, time a hit. Printed only.
    float uniform = 9;
    float face = 11;
    float vertex = 16;
    float lean = 21;
    // ns a vertex, one thread: chart `gradient`, deformation, gradient and V; refits by chart `bvh`. Printed only.
    float limit = 83;
    float analytic = 128;
    float refit = 39;
    // Light that meets several facets, ns a hit over single scattering: charts `multiscatter` and, for the variance, `plan`. The walk's
    // time grows with the share of the light that does, and so does its variance over that of single scattering. These decide whether
    // the compensation is a choice at all: only where it costs less than the walk at equal noise.
    float compensation = 240;
    float walk = 60;
    float walkLoss = 550;
    float walkVariance = 14;
    BvhCosts bvh;

    /// Of a walk where this share of the light meets several facets: time by variance.
    [[nodiscard]] float walkAt(float loss) const { return (walk + walkLoss * loss) * (1 + walkVariance * loss); }
};

} // namespace taut
