// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/client_places.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <vector>

namespace cas::base::rpc {
namespace {

using testing::HasSubstr;
using testing::Optional;

ClientOrigin origin(const std::string& text) {
  sockaddr_in v4{};
  v4.sin_family = AF_INET;
  if (::inet_pton(AF_INET, text.c_str(), &v4.sin_addr) == 1) {
    return tcp_origin(reinterpret_cast<const sockaddr&>(v4));
  }
  sockaddr_in6 v6{};
  v6.sin6_family = AF_INET6;
  EXPECT_EQ(::inet_pton(AF_INET6, text.c_str(), &v6.sin6_addr), 1) << text;
  return tcp_origin(reinterpret_cast<const sockaddr&>(v6));
}

constexpr uid_t kServer = 1000;
constexpr uid_t kMember = 1001;

std::vector<PlaceHolder> holders(std::size_t count, const ClientOrigin& from, bool asked) {
  return std::vector<PlaceHolder>(count, {from, asked, false});
}

std::vector<PlaceHolder> operator+(std::vector<PlaceHolder> a, const std::vector<PlaceHolder>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(ClientOrigin, AllOfLoopbackIsOneShare) {
  for (const char* address :
       {"127.0.0.1", "127.0.0.2", "127.255.255.254", "::1", "::ffff:127.0.0.9"}) {
    EXPECT_EQ(origin(address).share, "loopback") << address;
    EXPECT_TRUE(origin(address).loopback) << address;
  }
  EXPECT_FALSE(origin("128.0.0.1").loopback);
  EXPECT_FALSE(origin("::2").loopback);
}

TEST(ClientOrigin, AnIpv6NetworkOf64BitsIsOneShare) {
  EXPECT_EQ(origin("2001:db8:1:2::1").share, "2001:db8:1:2::/64");
  EXPECT_EQ(origin("2001:db8:1:2:ffff:ffff:ffff:ffff").share, "2001:db8:1:2::/64");
  EXPECT_NE(origin("2001:db8:1:3::1").share, "2001:db8:1:2::/64");
}

TEST(ClientOrigin, AnIpv4AddressIsItsOwnShare) {
  EXPECT_EQ(origin("192.0.2.7").share, "192.0.2.7");
  EXPECT_EQ(origin("::ffff:192.0.2.7").share, "192.0.2.7");
}

TEST(ClientOrigin, OperatorsAreRootAndTheServersOwnUser) {
  EXPECT_TRUE(unix_origin(0, kServer).is_operator);
  EXPECT_TRUE(unix_origin(kServer, kServer).is_operator);
  EXPECT_FALSE(unix_origin(kMember, kServer).is_operator);
  EXPECT_FALSE(origin("127.0.0.1").is_operator);
  EXPECT_EQ(unix_origin(kMember, kServer).share, "uid 1001");
}

TEST(ClientPlaces, AShareIsHalfOfThem) {
  const auto taken = holders(2, origin("127.0.0.1"), true);
  EXPECT_THAT(find_place(origin("127.0.0.2"), taken, 4, false).refusal,
              Optional(HasSubstr("one address")));
  EXPECT_EQ(find_place(origin("192.0.2.7"), taken, 4, false).refusal, std::nullopt);
  EXPECT_EQ(find_place(origin("127.0.0.2"), taken, 5, false).refusal, std::nullopt)
      << "half of 5 is 3";
}

TEST(ClientPlaces, AUserOnAUnixSocketHasAShareToo) {
  const auto taken = holders(2, unix_origin(kMember, kServer), true);
  EXPECT_THAT(find_place(unix_origin(kMember, kServer), taken, 4, true).refusal,
              Optional(HasSubstr("one user")));
  EXPECT_EQ(find_place(unix_origin(kMember + 1, kServer), taken, 4, true).refusal, std::nullopt);
}

TEST(ClientPlaces, TheLastIsForAnOperator) {
  const auto taken = holders(1, origin("127.0.0.1"), true) + holders(1, origin("192.0.2.7"), true) +
                     holders(1, unix_origin(kMember, kServer), true);
  EXPECT_NE(find_place(origin("192.0.2.8"), taken, 4, true).refusal, std::nullopt);
  EXPECT_NE(find_place(unix_origin(kMember + 1, kServer), taken, 4, true).refusal, std::nullopt);
  EXPECT_EQ(find_place(unix_origin(kServer, kServer), taken, 4, true).refusal, std::nullopt);
  EXPECT_EQ(find_place(unix_origin(0, kServer), taken, 4, true).refusal, std::nullopt);
  EXPECT_EQ(find_place(origin("192.0.2.8"), taken, 4, false).refusal, std::nullopt) << "TCP alone";
}

TEST(ClientPlaces, AnOperatorDisplacesTheClientThatHasBeenSilentLongest) {
  const auto taken = holders(1, origin("127.0.0.1"), true) +
                     holders(2, unix_origin(kServer, kServer), false) +
                     holders(1, origin("192.0.2.7"), false);
  const PlaceDecision decision = find_place(unix_origin(kServer, kServer), taken, 4, true);
  EXPECT_EQ(decision.refusal, std::nullopt);
  EXPECT_EQ(decision.displaced, 1U);
  EXPECT_EQ(find_place(origin("192.0.2.8"), taken, 4, true).displaced, 3U) << "no operator";
  EXPECT_EQ(find_place(unix_origin(0, kServer), taken, 5, true).displaced, std::nullopt)
      << "there is a place";
}

TEST(ClientPlaces, AFullShareLosesItsOldestStranger) {
  const auto taken = holders(1, origin("192.0.2.7"), false) +
                     holders(1, origin("127.0.0.1"), true) + holders(3, origin("127.0.0.1"), false);
  const PlaceDecision decision = find_place(origin("127.0.0.2"), taken, 8, true);
  EXPECT_EQ(decision.refusal, std::nullopt);
  EXPECT_EQ(decision.displaced, 2U) << "of its own share";
  auto speaking = taken;
  speaking[2].spoke = speaking[3].spoke = true;
  EXPECT_EQ(find_place(origin("127.0.0.2"), speaking, 8, true).displaced, 4U) << "the silent one";
  speaking[4].spoke = true;
  EXPECT_EQ(find_place(origin("127.0.0.2"), speaking, 8, true).displaced, 2U);
}

TEST(ClientPlaces, NobodyWhoHasAskedIsDisplaced) {
  const auto taken = holders(4, unix_origin(kServer, kServer), true);
  const PlaceDecision decision = find_place(unix_origin(kServer, kServer), taken, 4, true);
  EXPECT_NE(decision.refusal, std::nullopt);
  EXPECT_EQ(decision.displaced, std::nullopt);
}

}  // namespace
}  // namespace cas::base::rpc
