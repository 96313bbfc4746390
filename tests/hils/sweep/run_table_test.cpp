// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/run_table.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

Study study_of(const std::string& text) {
  const test::TemporaryFolder folder;
  return Study::load(folder.write("study.yaml", "schema: 1\nscenario: hover.yaml\n" + text));
}

TEST(RunTable, IsTheGridWithTheLastParameterFirstAndEachSeed) {
  const RunTable table = RunTable::of(study_of("seeds: [4, 9]\n"
                                               "vary:\n"
                                               "  - {name: a, key: x.a, values: [1, \"b,c\"]}\n"
                                               "  - {key: y, range: {from: 0, to: 1, count: 3}}\n"),
                                      1);
  EXPECT_EQ(table.csv(),
            "row,point,seed,a,y\n1,1,4,1,0\n2,1,9,1,0\n3,2,4,1,0.5\n4,2,9,1,0.5\n5,3,4,1,1\n"
            "6,3,9,1,1\n7,4,4,\"b,c\",0\n8,4,9,\"b,c\",0\n9,5,4,\"b,c\",0.5\n10,5,9,\"b,c\",0.5\n"
            "11,6,4,\"b,c\",1\n12,6,9,\"b,c\",1\n");
  EXPECT_EQ(RunTable::parse(table.csv(), "t").csv(), table.csv());
}

/// Quantiles of the Sobol points 0.5, 0.75, 0.25: of U(0, 8), of the logarithm between 1 and 100,
/// and of N(10, 2), whose quartiles are 10 +- 0.674489750 * 2.
TEST(RunTable, DrawsEachDistributionAtItsQuantiles) {
  const RunTable table = RunTable::of(study_of("sampling: sobol\npoints: 3\n"
                                               "seeds: {first: 5, each: row}\n"
                                               "vary:\n  - {key: u, uniform: [0, 8]}\n"),
                                      1);
  EXPECT_EQ(table.csv(), "row,point,seed,u\n1,1,5,4\n2,2,6,6\n3,3,7,2\n");
  const RunTable log =
      RunTable::of(study_of("sampling: sobol\npoints: 3\nvary:\n  - {key: l, log: [1, 100]}\n"), 3);
  EXPECT_EQ(log.csv(), "row,point,seed,l\n1,1,3,10\n2,2,3,31.6227766\n3,3,3,3.16227766\n");
  const RunTable normal =
      RunTable::of(study_of("sampling: sobol\npoints: 3\n"
                            "vary:\n  - {key: n, normal: {mean: 10, deviation: 2}}\n"),
                   3);
  EXPECT_EQ(normal.csv(), "row,point,seed,n\n1,1,3,10\n2,2,3,11.3489795\n3,3,3,8.6510205\n");
}

TEST(RunTable, ANormalThatIsCutStaysWithinItsEnds) {
  const RunTable table = RunTable::of(
      study_of("sampling: random\npoints: 500\nvary:\n"
               "  - {key: n, whole: true, normal: {mean: 0, deviation: 5, least: -3, most: 4}}\n"),
      1);
  for (const TableRow& row : table.rows) {
    const int value = std::stoi(row.values[0]);
    EXPECT_GE(value, -3);
    EXPECT_LE(value, 4);
  }
}

/// The table of a fixed study, to the byte: it is the same on every machine.
TEST(RunTable, OfALatinHypercubeIsTheSameOnEveryMachine) {
  const RunTable table = RunTable::of(study_of("sampling: latin_hypercube\npoints: 4\nseed: 3\n"
                                               "vary:\n  - {key: a, uniform: [0, 1]}\n"
                                               "  - {key: b, log: [1, 10]}\n"),
                                      1);
  EXPECT_EQ(table.csv(),
            "row,point,seed,a,b\n1,1,1,0.217357614,1.88264741\n2,2,1,0.677116046,7.82773325\n"
            "3,3,1,0.879946891,4.76464516\n4,4,1,0.354600932,1.52501335\n");
}

TEST(RunTable, ChunksAreEveryRowOnce) {
  for (const std::size_t n : {1U, 2U, 3U, 7U, 10U}) {
    std::size_t next = 1;
    for (std::size_t k = 1; k <= n; ++k) {
      const auto [first, last] = rows_of_chunk(10, k, n);
      EXPECT_EQ(first, next);
      EXPECT_GE(last - first, 10 / n);
      EXPECT_LE(last - first, 10 / n + 1);
      next = last;
    }
    EXPECT_EQ(next, 11U);
  }
}

TEST(RunTable, FieldsOfCsvComeBackAsTheyWere) {
  const std::vector<std::string> fields{"a", "", "b,c", "say \"no\"", "1.5"};
  std::string line;
  for (const std::string& field : fields) line += (line.empty() ? "" : ",") + csv_field(field);
  EXPECT_EQ(csv_fields(line), fields);
  EXPECT_TRUE(csv_fields("a,\"b").empty());
}

}  // namespace
}  // namespace cas::hils
