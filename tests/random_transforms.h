#pragma once
/// Random microsurface transforms of every kind, from one fixed seed.

#include "taut/microsurface/transform.h"

#include <random>
#include <vector>

namespace taut::test {

/// Diagonal, skewed, squashed, leaning and mirrored ones in turn, of the real type T; alpha from 0.1 to 2.
template <class T = float> std::vector<BasicMicroTransform<T>> randomTransforms(int count, bool leaning = true) {
    std::mt19937 random(2016);
    std::uniform_real_distribution<float> unit(0, 1);
    std::uniform_real_distribution<float> entry(-2, 2);
    const auto alpha = [&] { return std::exp(std::log(0.1F) + unit(random) * std::log(20.0F)); };
    std::vector<BasicMicroTransform<T>> transforms;
    while (static_cast<int>(transforms.size()) < count) {
        switch (transforms.size() % 5) {
        case 0: transforms.push_back(microTransformFromAlpha<T>(alpha(), alpha())); break;
        case 1: transforms.push_back(microTransform<T>(1 / alpha(), entry(random), 0, 1 / alpha())); break;
        case 2: transforms.push_back(microTransformFromAlpha<T>(1 + unit(random), 1 + 2 * unit(random), 3 * unit(random))); break;
        case 3: {
            const float p = leaning ? entry(random) : 0;
            transforms.push_back(microTransform<T>(1 / alpha(), entry(random), entry(random), 1 / alpha(), p, leaning ? entry(random) : 0));
            break;
        }
        default: transforms.push_back(microTransform<T>(entry(random), 1 + unit(random), 1 + unit(random), -0.2F)); break;
        }
    }
    return transforms;
}

} // namespace taut::test
