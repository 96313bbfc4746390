// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/cpu_latency.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>

#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

// A file in the device's place shows what the kernel would read.
TEST(CpuLatencyRequest, WritesMicrosecondsAsTheKernelReadsThem) {
  const test::TemporaryFolder folder;
  const auto device = folder.path() / "cpu_dma_latency";
  std::ofstream(device).close();
  const CpuLatencyRequest request(250, device);
  EXPECT_TRUE(request.in_force());
  std::int32_t told = 0;
  std::ifstream file(device, std::ios::binary);
  file.read(reinterpret_cast<char*>(&told), sizeof told);
  EXPECT_EQ(file.gcount(), 4);
  EXPECT_EQ(told, 250);
  EXPECT_EQ(file.peek(), std::ifstream::traits_type::eof());
}

TEST(CpuLatencyRequest, WithoutTheDeviceWarnsAndGoesOn) {
  const test::TemporaryFolder folder;
  testing::internal::CaptureStderr();
  const CpuLatencyRequest request(0, folder.path() / "none");
  EXPECT_FALSE(request.in_force());
  EXPECT_NE(testing::internal::GetCapturedStderr().find("idle processors may sleep"),
            std::string::npos);
}

TEST(CpuLatencyRequest, AsksForNothingUnlessTold) {
  const test::TemporaryFolder folder;
  testing::internal::CaptureStderr();
  EXPECT_FALSE(CpuLatencyRequest(std::nullopt, folder.path() / "none").in_force());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace cas::base
