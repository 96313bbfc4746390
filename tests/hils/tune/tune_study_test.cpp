// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_study.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

const std::string kStudy = R"(
schema: 1
scenarios:
  - {name: calm, scenario: scenarios/hover.yaml}
  - {name: late, scenario: scenarios/hover.yaml, delay_ramp: {from_s: 10, step_us: 5000, most_us: 20000}}
vary:
  - {name: position_p, key: controller.params.MPC_XY_P, log: [0.5, 2], from: 1}
  - {name: both, key: [controller.params.MC_ROLL_P, controller.params.MC_PITCH_P], uniform: [2, 12], from: 7}
objectives:
  - {name: error, figure: [rms_x_m, rms_y_m]}
guards:
  - {figure: delay_margin_us, in: [late], at_least: before}
search: {population: 8, generations: 1}
)";

class TuneStudyTest : public testing::Test {
 protected:
  TuneStudy load(const std::string& text) const {
    return TuneStudy::load(folder_.write("study.yaml", text));
  }
  std::string error_of(const std::string& text) const {
    return test::refusal([&] { load(text); });
  }
  static std::string with(const std::string& from, const std::string& to) {
    std::string text = kStudy;
    return text.replace(text.find(from), from.size(), to);
  }
  test::TemporaryFolder folder_;
};

TEST_F(TuneStudyTest, ReadsWhatIsSearchedAndWhatIsHeld) {
  const TuneStudy study = load(kStudy);
  EXPECT_EQ(study.objectives[0].figure.in, (std::vector<std::size_t>{0}));  // not the delay ramp
  EXPECT_EQ(study.guards[0].figure.name, "delay_margin_us");
  EXPECT_FALSE(study.guards[0].bound);
  EXPECT_EQ(study.scenarios[1].settings.back().first, "faults");
  EXPECT_EQ(study.before(), (std::vector<std::string>{"1", "7"}));
  EXPECT_EQ(study.values_of({"1.5", "6"}),
            (std::vector<KeyValue>{{"controller.params.MPC_XY_P", "1.5"},
                                   {"controller.params.MC_ROLL_P", "6"},
                                   {"controller.params.MC_PITCH_P", "6"}}));
}

TEST_F(TuneStudyTest, PlacesAreBetweenTheEnds) {
  const TuneStudy study = load(kStudy);
  EXPECT_DOUBLE_EQ(study.vary[0].place(), 0.5);  // of the logarithm
  EXPECT_DOUBLE_EQ(study.vary[1].place(), 0.5);
  EXPECT_EQ(study.vary[0].value_at(study.vary[0].place()), "1");
  EXPECT_EQ(study.vary[0].value_at(0), "0.5");
  EXPECT_EQ(study.vary[0].value_at(1), "2");
  EXPECT_EQ(study.vary[1].value_at(1.0 / 3), "5.333");  // four digits
}

/// As written, and never outside of the study's bounds.
TEST_F(TuneStudyTest, ValuesAreRoundedBetweenTheEnds) {
  const TuneStudy fine = load(with("[2, 12], from: 7", "[2.00001, 11.99999], from: 7.123456"));
  EXPECT_EQ(fine.before()[1], "7.123456");
  EXPECT_EQ(fine.vary[1].value_at(0), "2.00001");
  EXPECT_EQ(fine.vary[1].value_at(1), "11.99999");
  const TuneStudy whole = load(with("[2, 12], from: 7", "[2, 123456.7], from: 12345, whole: true"));
  EXPECT_EQ(whole.before()[1], "12345");
  EXPECT_EQ(whole.vary[1].value_at(1), "123456");
  EXPECT_EQ(whole.vary[1].value_at(0.1), "12347");
}

struct WrongStudy {
  const char* name;
  const char* from;
  const char* to;
  const char* sentence;
};
class WrongTuneStudy : public TuneStudyTest, public testing::WithParamInterface<WrongStudy> {};

TEST_P(WrongTuneStudy, IsRefusedInASentence) {
  const std::string error = error_of(with(GetParam().from, GetParam().to));
  EXPECT_NE(error.find(GetParam().sentence), std::string::npos) << error;
}

INSTANTIATE_TEST_SUITE_P(
    Tune, WrongTuneStudy,
    testing::Values(
        WrongStudy{"FromOutside", "from: 7", "from: 20", "from"},
        WrongStudy{"NoEnds", "uniform: [2, 12]", "normal: {mean: 7, deviation: 1}",
                   "has `uniform` or `log`"},
        WrongStudy{"Scenario", "in: [late]", "in: [later]", "is none of the study's scenarios"},
        WrongStudy{"TwoBounds", "at_least: before", "at_least: 1, at_most: 2",
                   "has at_least or at_most"},
        WrongStudy{"NoBound", ", at_least: before", "", "has at_least or at_most"},
        WrongStudy{"Population", "population: 8", "population: 10", "is a multiple of 4"},
        WrongStudy{"Seeds", "search:", "verify: {seeds: [1, 2]}\nsearch:",
                   "has seed 1, which the search uses"},
        WrongStudy{"Dots", "name: late", "name: '..'", "has more than dots"},
        WrongStudy{"SameName", "name: late", "name: calm", "is a scenario's already"},
        WrongStudy{"Misspelt", "guards:", "guard:", "guard"}),
    [](const auto& test) { return test.param.name; });

TEST(ShippedTuning, CanBeRead) {
  const TuneStudy study = TuneStudy::load(test::source_dir() + "/config/tunings/iris_paper.yaml");
  EXPECT_FALSE(study.verify_seeds.empty());
  EXPECT_FALSE(study.guards.empty());
}

}  // namespace
}  // namespace cas::hils
