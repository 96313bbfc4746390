// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/run_journal.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

namespace cas::sim {
namespace {

using nlohmann::json;

const std::string kHils = "unix:uid 1000";
const std::string kOther = "unix:uid 1001";

NotedCall run_until(double time_s, const std::string& client = kHils) {
  return {.time_s = time_s,
          .client = client,
          .method = "sim.run_until",
          .params = json{{"time_s", time_s}}.dump()};
}

TEST(RunJournal, AnEarlyCallOutlastsThoseThatDriveARunInLockstep) {
  RunJournal journal;
  journal.note({.client = kOther, .method = "sim.pause"});
  for (int i = 1; i <= 5000; ++i) journal.note(run_until(i));
  const json noted = journal.json();
  EXPECT_EQ(noted["forgotten"], 0);
  ASSERT_EQ(noted["calls"].size(), 2U) << noted;
  EXPECT_EQ(noted["calls"][0]["method"], "sim.pause");
  EXPECT_EQ(noted["calls"][0]["client"], kOther);
  EXPECT_FALSE(noted["calls"][0].contains("times"));
  EXPECT_EQ(noted["calls"][1]["times"], 5000);
  EXPECT_EQ(noted["calls"][1]["time_s"], 1) << "of the first";
  EXPECT_EQ(noted["calls"][1]["params"]["time_s"], 5000) << "of the last";
}

TEST(RunJournal, WhatComesBetweenOrFromAnotherClientIsAnEntryOfItsOwn) {
  RunJournal journal;
  journal.note(run_until(1));
  journal.note(run_until(2, kOther));
  journal.note(run_until(3));
  journal.note({.client = kHils, .method = "sim.fault"});
  journal.note({.client = kHils, .method = "sim.fault"});
  journal.note(run_until(4));
  EXPECT_EQ(journal.json()["calls"].size(), 6U) << journal.json();
}

TEST(RunJournal, CountsTheOldestCallsThatItHasNoRoomFor) {
  RunJournal journal;
  for (std::size_t i = 0; i < RunJournal::kMost + 3; ++i) {
    journal.note({.time_s = static_cast<double>(i), .client = kHils, .method = "sim.pause"});
  }
  const json noted = journal.json();
  EXPECT_EQ(noted["forgotten"], 3);
  ASSERT_EQ(noted["calls"].size(), RunJournal::kMost);
  EXPECT_EQ(noted["calls"][0]["time_s"], 3);
}

}  // namespace
}  // namespace cas::sim
