// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sampling.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace cas::hils {
namespace {

using Points = std::vector<std::vector<double>>;

/// The first points of the sequence of Joe and Kuo's own program (sobol.cc with
/// new-joe-kuo-6.21201) behind its corner at 0; dimension 2 is van der Corput's in another order, 3
/// the first with a polynomial of degree 2.
TEST(Sampling, SobolBeginsAsJoeAndKuosProgramDoes) {
  const Points points = unit_points(Sampling::kSobol, 7, {"a", "b", "c"}, 1);
  const Points expected{{0.5, 0.5, 0.5},       {0.75, 0.25, 0.25},    {0.25, 0.75, 0.75},
                        {0.375, 0.375, 0.625}, {0.875, 0.875, 0.125}, {0.625, 0.125, 0.875},
                        {0.125, 0.625, 0.375}};
  EXPECT_EQ(points, expected);
}

TEST(Sampling, LatinHypercubeHasOnePointInEachShareOfEachParameter) {
  constexpr std::size_t kCount = 20;
  const Points points = unit_points(Sampling::kLatinHypercube, kCount, {"a", "b"}, 7);
  for (std::size_t j = 0; j < 2; ++j) {
    std::set<int> shares;
    for (const auto& point : points) shares.insert(static_cast<int>(point[j] * kCount));
    EXPECT_EQ(shares.size(), kCount);
  }
}

TEST(Sampling, RandomPointsAreThoseOfTheSeedAndOfTheNameAlone) {
  const Points one = unit_points(Sampling::kRandom, 5, {"a"}, 7);
  const Points two = unit_points(Sampling::kRandom, 5, {"b", "a"}, 7);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i][0], two[i][1]);
  EXPECT_NE(one, unit_points(Sampling::kRandom, 5, {"a"}, 8));
}

TEST(Sampling, NoPointIsOnTheEdge) {
  for (const Sampling sampling : {Sampling::kRandom, Sampling::kLatinHypercube, Sampling::kSobol}) {
    for (const auto& point : unit_points(sampling, 500, {"a", "b"}, 1)) {
      for (const double u : point) {
        EXPECT_GT(u, 0);
        EXPECT_LT(u, 1);
      }
    }
  }
}

}  // namespace
}  // namespace cas::hils
