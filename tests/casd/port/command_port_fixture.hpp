// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "tests/casd/fake_vehicle.hpp"

namespace cas::casd::test {

/// A command port on a free TCP port of this process, with a commander and scripted vehicles behind
/// it, on a thread of its own in real time. Scripts are set before start().
class CommandPortFixture {
 public:
  CommandPortFixture();
  ~CommandPortFixture();

  /// The vehicles; system ids 1, 2, ... in order. Not to be touched while it runs.
  FakeVehicle& vehicle(std::size_t index = 0);
  FakeVehicle& add_vehicle();
  void allow_not_hil();
  void require_token(const std::string& file);

  /// Returns once every vehicle has been heard.
  void start();
  /// Ends the thread: vehicles may be looked at again.
  void stop();
  /// "127.0.0.1:PORT".
  const std::string& address() const;
  /// Lines of the audit log, after stop().
  const std::vector<std::string>& audit() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::casd::test
