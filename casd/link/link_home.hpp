// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>

#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/link/link_loop.hpp"

namespace cas::casd {

/// Which loop serves a link: always the same one, or (`threads: auto`) the one that links share,
/// and one of its own while it floods, so that it does not delay the others.
class LinkHome {
 public:
  /// The link shares this loop for good.
  explicit LinkHome(std::shared_ptr<LinkLoop> shared);
  /// The link has this loop for itself.
  explicit LinkHome(std::unique_ptr<LinkLoop> own);
  /// The link shares `shared`, unless it floods.
  /// @param make_own  makes the loop for a flood
  LinkHome(std::shared_ptr<LinkLoop> shared, std::function<std::unique_ptr<LinkLoop>()> make_own);

  /// Starts the loop that is the link's own, if there is one.
  /// @throws base::ConfigError when there is no thread to be had
  void start();
  void add(std::unique_ptr<Link> link);
  /// Closes the link; returns when it is closed. Its own loop ends, too.
  void remove(const Link* link);
  /// From now on the link stays with its present loop.
  void stay();
  /// Ends the link's own loop and closes the link if it is there; the shared loop goes on.
  void stop();

  // From any thread:
  void wake();
  bool answers(base::RunTime now, base::Duration patience);

  // By the loop that serves the link, on its thread. `take` returns whether it has taken the link.

  /// Whether the link can have a loop of its own: it is made if there is none.
  bool has_own_loop(base::RunTime now);
  /// The link floods a loop that it shares. After has_own_loop().
  bool take_flooding(std::unique_ptr<Link>& link);
  /// Takes back a link whose flood is over.
  bool take_calm(std::unique_ptr<Link>& link);

 private:
  const std::shared_ptr<LinkLoop> shared_;
  const std::function<std::unique_ptr<LinkLoop>()> make_own_;
  base::RunTime try_again_{};  ///< to make it; of the shared loop's thread
  base::Mutex mutex_;
  std::unique_ptr<LinkLoop> own_ CAS_GUARDED_BY(mutex_);  ///< kept after its first flood
  LinkLoop* at_ CAS_GUARDED_BY(mutex_);                   ///< nullptr: stopped
  bool stays_ CAS_GUARDED_BY(mutex_) = false;
};

}  // namespace cas::casd
