// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/session.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <filesystem>

#include "base/os/descriptor.hpp"
#include "base/rpc/local_port.hpp"
#include "tests/base/config/scoped_environment.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casctl {
namespace {

/// Takes connections and answers none.
base::Descriptor listen_at(const std::filesystem::path& path) {
  base::Descriptor fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  EXPECT_EQ(::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(::listen(fd.get(), 4), 0);
  return fd;
}

TEST(Session, KeepsToTheCasdThatItFound) {
  const test::TemporaryFolder folder;
  const base::ScopedEnvironment runtime("CAS_RUNTIME_DIR", (folder.path() / "cas").c_str());
  const std::filesystem::path own = base::rpc::make_runtime_folder();
  const base::Descriptor first = listen_at(own / "casd-2.sock");
  const Session session{Options{}};
  EXPECT_EQ(session.options().address, "unix:" + (own / "casd-2.sock").string());

  const base::Descriptor second = listen_at(own / "casd-1.sock");
  EXPECT_EQ(Session(session.options()).options().address, session.options().address)
      << "the monitor must not command another vehicle when a second casd starts";
}

}  // namespace
}  // namespace cas::casctl
