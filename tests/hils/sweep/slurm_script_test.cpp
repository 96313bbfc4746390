// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/slurm_script.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

TEST(SlurmScript, ChunksTakeMinutes) {
  EXPECT_EQ(slurm_chunks(1'000'000, 0.5, 1, 10), 834U);
  EXPECT_EQ(slurm_chunks(1'000'000, 0.5, 4, 10), 209U);
  EXPECT_EQ(slurm_chunks(100'000'000, 1, 1, 10), 1000U);
  EXPECT_EQ(slurm_chunks(3, 600, 1, 1), 3U);
  EXPECT_EQ(slurm_chunks(10, 0.1, 1, 10), 1U);
}

TEST(SlurmScript, RangesAreAsShortAsTheyCanBe) {
  EXPECT_EQ(slurm_ranges({1, 2, 3, 7, 9, 10}), "1-3,7,9-10");
  EXPECT_EQ(slurm_ranges({5}), "5");
}

TEST(SlurmScript, IsOneArrayOfChunks) {
  EXPECT_EQ(slurm_script({.name = "my study",
                          .program = "/opt/cas/bin/hils",
                          .sweep = "/home/o'neil/sweep",
                          .logs = "/home/o'neil/sweep/slurm",
                          .chunks = 40,
                          .missing = {3, 4},
                          .jobs = 2,
                          .minutes = 45,
                          .partition = "long"}),
            "#!/bin/sh\n"
            "#SBATCH --job-name=sweep-my_study\n"
            "#SBATCH --array=3-4\n"
            "#SBATCH --cpus-per-task=2\n"
            "#SBATCH --time=45\n"
            "#SBATCH --output=\"/home/o'neil/sweep/slurm/%A_%a.log\"\n"
            "#SBATCH --partition=long\n"
            "exec '/opt/cas/bin/hils' sweep run '/home/o'\\''neil/sweep' "
            "--chunk \"$SLURM_ARRAY_TASK_ID/40\" --jobs 2 --scratch \"${TMPDIR:-/tmp}\"\n");
}

}  // namespace
}  // namespace cas::hils
