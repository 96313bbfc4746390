// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>

#include "base/rpc/message.hpp"
#include "base/time/clock.hpp"

namespace cas::web {

/// The picture of the links, `snap.links`: a hop for each way of a link over which HIL packets go,
/// with its ends ("sim", "casd", "fcu") and its vehicle, from casd's answers to link.list,
/// message.list and link.latency. Reads no clock.
class LinkReport {
 public:
  base::rpc::Json make(const base::rpc::Json& links, const base::rpc::Json& messages,
                       const base::rpc::Json& latency, base::RunTime now);

 private:
  /// Role and vehicle at a link's other end; 0: unknown.
  struct End {
    std::string role;
    int system = 0;
  };

  /// How full a serial line is, from its bytes since the last report; below 0: not known.
  double share(const std::string& way, double bytes, double baud, base::RunTime now);
  void add_link(base::rpc::Json& hops, const base::rpc::Json& link, const base::rpc::Json& messages,
                base::RunTime now);
  std::string role_of(const std::string& link) const;

  std::map<std::string, End> ends_;                                // by link
  std::map<std::string, std::pair<base::RunTime, double>> bytes_;  // at the last report, by way
};

}  // namespace cas::web
