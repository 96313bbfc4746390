// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/link_home.hpp"

#include <chrono>
#include <exception>
#include <string>
#include <utility>

#include "base/os/log.hpp"

namespace cas::casd {

LinkHome::LinkHome(std::shared_ptr<LinkLoop> shared)
    : shared_(std::move(shared)), at_(shared_.get()) {}

LinkHome::LinkHome(std::unique_ptr<LinkLoop> own) : own_(std::move(own)), at_(own_.get()) {}

LinkHome::LinkHome(std::shared_ptr<LinkLoop> shared,
                   std::function<std::unique_ptr<LinkLoop>()> make_own)
    : shared_(std::move(shared)), make_own_(std::move(make_own)), at_(shared_.get()) {}

void LinkHome::start() {
  const base::MutexLock lock(mutex_);
  if (own_) own_->start();
}

void LinkHome::add(std::unique_ptr<Link> link) {
  const base::MutexLock lock(mutex_);
  at_->add(std::move(link), this);
}

// The link may move meanwhile; then its new loop is asked.
void LinkHome::remove(const Link* link) {
  const auto place = [this] {
    const base::MutexLock lock(mutex_);
    return at_;
  };
  if (shared_) {
    for (LinkLoop* at = place(); at != nullptr && !at->remove(link);) at = place();
  }
  stop();
}

void LinkHome::stay() {
  const base::MutexLock lock(mutex_);
  stays_ = true;
}

void LinkHome::stop() {
  std::unique_ptr<LinkLoop> own;
  {
    const base::MutexLock lock(mutex_);
    stays_ = true;
    at_ = nullptr;
    own = std::move(own_);
  }
  if (own) own->stop();
}

void LinkHome::wake() {
  const base::MutexLock lock(mutex_);
  if (at_ != nullptr) at_->wake();
}

// The other loop is woken, too: it must not look as if it hung when the link moves there.
bool LinkHome::answers(base::RunTime now, base::Duration patience) {
  const base::MutexLock lock(mutex_);
  for (LinkLoop* other : {shared_.get(), own_.get()}) {
    if (other != nullptr && other != at_) other->answers(now, patience);
  }
  return at_ == nullptr || at_->answers(now, patience);
}

bool LinkHome::take_flooding(std::unique_ptr<Link>& link) {
  const base::MutexLock lock(mutex_);
  if (stays_ || !own_ || at_ == own_.get()) return false;
  own_->add(std::move(link), this, true);
  at_ = own_.get();
  base::log::info("link " + own_->name() + ": floods, and has a thread of its own");
  return true;
}

bool LinkHome::take_calm(std::unique_ptr<Link>& link) {
  const base::MutexLock lock(mutex_);
  if (stays_ || !shared_ || at_ == shared_.get()) return false;
  shared_->add(std::move(link), this);
  at_ = shared_.get();
  base::log::info("link " + own_->name() + ": floods no more, and shares its thread again");
  return true;
}

// A thread takes its time: the lock is not held meanwhile.
bool LinkHome::has_own_loop(base::RunTime now) {
  {
    const base::MutexLock lock(mutex_);
    if (stays_ || !make_own_ || now < try_again_) return false;
    if (own_) return true;
  }
  try {
    std::unique_ptr<LinkLoop> own = make_own_();
    own->start();
    const base::MutexLock lock(mutex_);
    own_ = std::move(own);
    return true;
  } catch (const std::exception& error) {
    constexpr auto kPatience = std::chrono::seconds(10);
    try_again_ = now + kPatience;
    base::log::warn(std::string("a link that floods stays with the others: ") + error.what());
    return false;
  }
}

}  // namespace cas::casd
