// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "base/os/descriptor.hpp"

namespace cas::casd {

/// What one turn of a link loop has taken from its thread. Processor time, never elapsed time: a
/// busy machine is no fault of the loop.
struct TurnUse {
  std::chrono::nanoseconds processor{};
  std::uint64_t read_bytes = 0;  ///< by read(2) and its kin, of files and of descriptors
  std::uint64_t waits = 0;       ///< sleeps for a disk or a lock
};

/// The sentence about a turn that has taken too much; nullopt for a turn within its bounds.
/// @param links  number of links that the thread serves
std::optional<std::string> excess(const TurnUse& use, std::size_t links);

/// To be called before a sleep that belongs to the thread's work, as with `threads: blocking` the
/// wait for the line. Such a sleep does not count among TurnUse::waits.
void count_wanted_wait();

/// Measures the turns of the thread that made it.
class TurnMeter {
 public:
  TurnMeter();
  void begin();
  /// Since begin(). What the kernel does not count stays 0.
  TurnUse end() const;

 private:
  TurnUse now() const;

  base::Descriptor io_;  ///< /proc/thread-self/io
  TurnUse begin_;
};

}  // namespace cas::casd
