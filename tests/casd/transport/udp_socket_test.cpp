// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/udp_socket.hpp"

#include <gtest/gtest.h>

#include "base/os/descriptor.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd::test {
namespace {

TEST(DatagramReader, TellsWhatTheKernelDropped) {
  const SocketAddress any = AddressLookup("127.0.0.1:0").address();
  const base::Descriptor in(open_udp_socket(any.family(), ""));
  ASSERT_EQ(::bind(in.get(), any.get(), any.size), 0);
  const int small = 8192;
  ASSERT_EQ(::setsockopt(in.get(), SOL_SOCKET, SO_RCVBUF, &small, sizeof small), 0);
  const base::Descriptor out(open_udp_socket(any.family(), ""));
  const SocketAddress to = local_address(in.get());
  constexpr unsigned kSent = 1000;
  const std::array<char, 60> packet{};
  const auto send = [&] {
    ASSERT_EQ(::sendto(out.get(), packet.data(), packet.size(), 0, to.get(), to.size), 60);
  };
  for (unsigned i = 0; i < kSent; ++i) send();

  DatagramReader reader;
  unsigned received = 0;
  while (const int count = reader.read(in.get())) received += static_cast<unsigned>(count);
  send();  // the count comes with the next datagram
  received += static_cast<unsigned>(reader.read(in.get()));
  EXPECT_LT(received, kSent);
  EXPECT_EQ(received + reader.kernel_drops(), kSent + 1);
}

}  // namespace
}  // namespace cas::casd::test
