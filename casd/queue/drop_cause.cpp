// SPDX-License-Identifier: BSD-3-Clause
#include "casd/queue/drop_cause.hpp"

namespace cas::casd {

std::string_view to_string(DropCause cause) {
  switch (cause) {
    case DropCause::kAge:
      return "age";
    case DropCause::kBandwidth:
      return "bandwidth";
    case DropCause::kQueueFull:
      return "queue_full";
    case DropCause::kClosed:
      return "closed";
    case DropCause::kStalled:
      return "stalled";
    case DropCause::kUnsignable:
      return "unsignable";
    case DropCause::kSuperseded:
      return "superseded";
  }
  return "?";
}

}  // namespace cas::casd
