// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/figure_book.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "tests/libsim/support/sim_files.hpp"

namespace cas::sim {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

FigureSpec spec(const std::string& name, const std::string& unit = "V",
                FigureKind kind = FigureKind::kSeries) {
  return {.vehicle = "iris0", .plugin = "battery", .name = name, .unit = unit, .kind = kind};
}

FigureSample at(base::Duration time, double value) { return {base::SimTime(time), value}; }

TEST(FigureRecord, KeepsAPointEvery20Milliseconds) {
  FigureRecord record(spec("voltage"));
  for (int ms = 0; ms < 1000; ++ms) record.add(at(milliseconds(ms), ms));
  EXPECT_EQ(record.samples(), 1000U);
  ASSERT_EQ(record.points().size(), 50U);
  EXPECT_EQ(record.points()[1].first, base::SimTime(milliseconds(20)));
  EXPECT_THAT(
      record.json(),
      HasSubstr(R"("samples":1000,"not_finite":0,"last":999,"min":0,"max":999,"mean":499.5)"));
}

TEST(FigureRecord, SpansALongRunWithTheSameMemory) {
  FigureRecord record(spec("voltage"));
  const int count = 5 * static_cast<int>(FigureRecord::kMostPoints);
  for (int i = 0; i < count; ++i) record.add(at(milliseconds(20) * i, i));
  EXPECT_LE(record.points().size(), FigureRecord::kMostPoints);
  EXPECT_GE(record.points().size(), FigureRecord::kMostPoints / 2);
  EXPECT_EQ(record.points().front().second, 0);
  EXPECT_NEAR(record.points().back().second, count, 8);
  for (std::size_t i = 1; i < record.points().size(); ++i) {
    ASSERT_EQ(record.points()[i].first - record.points()[i - 1].first, milliseconds(160)) << i;
  }
}

TEST(FigureRecord, LeavesOutWhatIsNotFinite) {
  FigureRecord record(spec("voltage"));
  record.add(at(milliseconds(0), std::numeric_limits<double>::quiet_NaN()));
  EXPECT_THAT(record.json(), HasSubstr(R"("samples":0,"not_finite":1,"last":null,"min":null)"));
  record.add(at(milliseconds(20), -3));
  record.add(at(milliseconds(40), std::numeric_limits<double>::infinity()));
  EXPECT_THAT(
      record.json(),
      HasSubstr(
          R"("samples":1,"not_finite":2,"last":-3,"min":-3,"max":-3,"mean":-3,"points":[[0.02,-3]])"));
}

TEST(FigureRecord, HasNoMeanWhereTheSumIsBeyondANumber) {
  FigureRecord record(spec("voltage"));
  const double largest = std::numeric_limits<double>::max();
  record.add(at(milliseconds(0), largest));
  record.add(at(milliseconds(20), largest));
  EXPECT_THAT(record.json(), HasSubstr(R"("mean":null)"));
  EXPECT_THAT(record.json(), testing::Not(HasSubstr("inf")));
}

TEST(FigureRecord, KeepsTheLastValueOfAScalar) {
  FigureRecord record(spec("least \"voltage\"", "\\V", FigureKind::kScalar));
  record.add(at(milliseconds(0), 2));
  record.add(at(milliseconds(1), 1));
  EXPECT_EQ(record.json(),
            R"({"vehicle":"iris0","plugin":"battery","name":"least \"voltage\"","unit":"\\V",)"
            R"("kind":"scalar","samples":2,"not_finite":0,"last":1})");
  record.reset();
  EXPECT_THAT(record.json(), HasSubstr(R"("samples":0,"not_finite":0,"last":null)"));
}

TEST(FigureBook, TakesNamesThatCanBeShown) {
  TopicBus bus;
  FigureBook book;
  for (const std::string& name :
       {std::string("voltage"), std::string("\xC2\xB5-field, \xE2\x82\xAC"), std::string(48, 'x'),
        std::string("<b>")}) {
    EXPECT_NO_THROW((void)book.add(bus, spec(name))) << name;
  }
  for (const std::string& name :
       {std::string(), std::string(49, 'x'), std::string("a\nb"), std::string("a\0b", 3),
        std::string("\x7F"), std::string("\xC2\x85"), std::string("\xC3"), std::string("\xC0\xAF"),
        std::string("\xED\xA0\x80"), std::string("\xFF"), std::string("voltage")}) {
    EXPECT_THROW((void)book.add(bus, spec(name)), base::ConfigError) << name;
  }
  EXPECT_THROW((void)book.add(bus, spec("current", "A\x1B[31m")), base::ConfigError);
}

TEST(FigureBook, BoundsTheFiguresOfAPlugin) {
  TopicBus bus;
  FigureBook book;
  EXPECT_TRUE(book.empty());
  for (std::size_t i = 0; i < FigureBook::kMostOfAPlugin; ++i) {
    (void)book.add(bus, spec(std::to_string(i), "", FigureKind::kScalar));
  }
  EXPECT_THAT(test::refusal([&] { (void)book.add(bus, spec("one more")); }),
              HasSubstr("at most 64 figures"));
  FigureSpec other = spec("one more");
  other.plugin = "flow";
  book.add(bus, other).publish(at(milliseconds(20), 0.1));
  EXPECT_THAT(book.json(), HasSubstr(R"("plugin":"flow","name":"one more")"));
  EXPECT_THAT(book.json(), HasSubstr(R"("points":[[0.02,0.1]])"));
}

}  // namespace
}  // namespace cas::sim
