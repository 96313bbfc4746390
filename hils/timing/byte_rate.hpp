// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "base/time/clock.hpp"

namespace cas::hils {

/// Rate of a stream of bytes that fills its line, from the moments at which parts of it were
/// through. The median of five pieces, so that neither the filling of the line nor one pause of
/// this machine counts.
///
/// After a pause this machine reads all waiting answers within a moment: a bunch of marks. From the
/// first mark of a bunch to the last the line looks faster than it is, so pieces begin and end only
/// at the last mark of a bunch.
class ByteRate {
 public:
  /// So many bytes are through, in all; 0 when the stream begins.
  void add(std::size_t total, base::RunTime now) { marks_.push_back({total, now}); }
  /// 0: too few marks.
  double bytes_s() const;

 private:
  struct Mark {
    std::size_t total = 0;
    base::RunTime at{};
  };

  std::vector<Mark> ends_of_bunches() const;

  std::vector<Mark> marks_;
};

}  // namespace cas::hils
