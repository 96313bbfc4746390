// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/link_loop.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/timerfd.h>

#include <fmt/format.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <future>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/os/lack_of_memory.hpp"
#include "base/os/log.hpp"
#include "casd/link/core_seeker.hpp"
#include "casd/link/link_home.hpp"

namespace cas::casd {
namespace {

// In builds with sanitizers, and with the CMake option CAS_METER_TURNS.
#ifdef CAS_METER_TURNS
constexpr bool kMeterTurns = true;
#else
constexpr bool kMeterTurns = false;
#endif

constexpr auto kTroublePause = std::chrono::milliseconds(100);
constexpr auto kNoMemoryPause = std::chrono::milliseconds(1);

timespec until(base::RunTime end, base::RunTime now) {
  const std::int64_t left = std::max<std::int64_t>((end - now).count(), 0);
  return {static_cast<time_t>(left / 1'000'000'000), left % 1'000'000'000};
}

/// Puts the calling thread on the core that its CoreSeeker wants.
class CoreSearch {
 public:
  /// @param name  of the thread, for the log
  CoreSearch(std::string name, bool wanted)
      : name_(std::move(name)),
        any_(base::allowed_cpus()),
        seeker_(wanted && times_.read() ? any_ : std::vector<int>{}) {}

  /// After each turn of the thread's loop.
  /// @param links     how many the thread serves: their figures begin anew when one comes or goes
  /// @param arrivals  called once in a while
  template <class ReadArrivals>
  void turned(base::RunTime now, bool flooded, std::size_t links, ReadArrivals&& arrivals) {
    if (!seeker_.seeks()) return;
    if (std::exchange(links_, links) != links) arrived_before_ = arrivals();
    if (flooded) {
      seeker_.release(now);
      return bind();
    }
    if (++turns_ < seeker_.sample_turns()) return;
    turns_ = 0;
    const std::optional<base::ThreadTimes> times = times_.read();
    if (!times) return;
    const Arrivals arrived = arrivals();
    seeker_.take({.turns = times->turns - times_before_.turns,
                  .elapsed = now - taken_at_,
                  .ran = times->ran - times_before_.ran,
                  .queued = times->queued - times_before_.queued,
                  .stamped = arrived.packets - arrived_before_.packets,
                  .arrival = arrived.waited - arrived_before_.waited},
                 now);
    taken_at_ = now;
    times_before_ = *times;
    arrived_before_ = arrived;
    bind();
  }

 private:
  void bind() {
    const std::optional<int> core = seeker_.core();
    const bool trying = core && !seeker_.settled();
    if (!trying && core != std::exchange(told_, core)) tell(core.has_value());
    if (core == bound_) return;
    bound_ = core;
    base::bind_to_cpus(core ? std::vector<int>{*core} : any_);
  }

  void tell(bool settled) const {
    constexpr auto kUs = std::chrono::microseconds(1);
    base::log::debug(
        settled
            ? fmt::format("thread {}: a packet costs {} us on core {}, {} us without a choice",
                          name_, seeker_.cost() / kUs, *seeker_.core(), seeker_.free_cost() / kUs)
            : "thread " + name_ + ": runs on any core");
  }

  const std::string name_;
  const std::vector<int> any_;
  const base::ThreadTimesReader times_;
  CoreSeeker seeker_;
  std::optional<int> bound_;
  std::optional<int> told_;  ///< in the log
  std::uint64_t turns_ = 0;
  std::size_t links_ = 0;
  base::RunTime taken_at_{};
  base::ThreadTimes times_before_;
  Arrivals arrived_before_;
};

}  // namespace

LinkLoop::LinkLoop(std::string name, base::ThreadOptions scheduling, bool seek_core)
    : name_(std::move(name)),
      scheduling_(std::move(scheduling)),
      seek_core_(seek_core),
      metered_(kMeterTurns) {}

LinkLoop::~LinkLoop() { stop(); }

void LinkLoop::start() {
  try {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  } catch (const std::system_error& error) {
    throw base::ConfigError("no thread for links (" + name_ + "): " + error.code().message());
  }
}

void LinkLoop::stop() {
  thread_.request_stop();
  signal_.raise();
  if (thread_.joinable()) thread_.join();
  links_.clear();
  taken_.clear();
  std::vector<std::function<void()>> never_run;
  const base::MutexLock lock(tasks_mutex_);
  never_run.swap(tasks_);
}

void LinkLoop::add(std::unique_ptr<Link>&& link, LinkHome* home, bool visits) {
  {
    const base::MutexLock lock(tasks_mutex_);
    // std::function must be copyable, a Link is not.
    const auto shared = std::make_shared<std::unique_ptr<Link>>();
    tasks_.emplace_back([this, shared, home, visits] {
      links_.reserve(links_.size() + 1);
      if (links_.empty()) pace_ = LookPace();
      const std::uint64_t received = (*shared)->received();
      pace_.add_link(received);
      links_.push_back(
          {.link = std::move(*shared), .home = home, .visits = visits, .received = received});
    });
    *shared = std::move(link);
  }
  signal_.raise();
}

bool LinkLoop::remove(const Link* link) {
  bool removed = false;
  run_on_loop([this, link, &removed] {
    const auto is_it = [link](const Resident& resident) { return resident.link.get() == link; };
    removed = std::erase_if(links_, is_it) > 0;
  });
  return removed;
}

void LinkLoop::run_on_loop(const std::function<void()>& task) {
  // Shared: the loop's thread is not through with it when we already go on.
  const auto done = std::make_shared<std::promise<void>>();
  std::future<void> finished = done->get_future();
  {
    const base::MutexLock lock(tasks_mutex_);
    tasks_.emplace_back([&task, done] {
      task();
      done->set_value();
    });
  }
  signal_.raise();
  finished.wait();
}

void LinkLoop::wake() {
  if (thread_id_.load(std::memory_order_relaxed) == std::this_thread::get_id()) return;
  signal_.raise();
}

bool LinkLoop::answers(base::RunTime now, base::Duration patience) {
  const base::RunTime last{base::Duration(last_turn_ns_.load(std::memory_order_relaxed))};
  signal_.raise();
  return last == base::RunTime{} || now - last < patience;
}

void LinkLoop::run(const std::stop_token& stop) {
  thread_id_.store(std::this_thread::get_id(), std::memory_order_relaxed);
  std::optional<CoreSearch> core_search;
  base::outlive_lack_of_memory(name_, [&] {
    base::configure_this_thread("casd:" + name_, scheduling_);
    core_search.emplace(name_, seek_core_);
  });
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);  // pacing counts in parts of a millisecond
  if (metered_) meter_.emplace();
  begin_turn();
  base::RunTime now = base::steady_now();
  while (!stop.stop_requested()) {
    run_tasks();
    const bool waited = base::outlive_lack_of_memory(name_, [&] { now = wait(now); });
    last_turn_ns_.store(now.time_since_epoch().count(), std::memory_order_relaxed);
    if (!waited) {
      now = base::steady_now();
      std::this_thread::sleep_for(kTroublePause);
      continue;
    }
    if (!serve(now)) std::this_thread::sleep_for(kNoMemoryPause);
    base::outlive_lack_of_memory(name_, [&] {
      if (pace_.looked(now, received(), idle_)) {
        move_links(now);
        note_received();
      }
      if (!core_search) return;
      core_search->turned(now, pace_.busy(), links_.size(), [this] { return arrivals(); });
    });
  }
  has_tasks_ = true;  // those that came with the stop
  run_tasks();
}

/// Gives each link its turn. A link that lacks memory loses this turn alone: its work is still due
/// at the next one.
/// @return false when one lacked memory
bool LinkLoop::serve(base::RunTime now) {
  bool served = true;
  for (const Resident& resident : links_) {
    const auto turn = [&] { resident.link->serve(poll_set_, now); };
    served &= base::outlive_lack_of_memory(name_, turn);
  }
  return served;
}

/// @param now  may be a turn old: it serves to tell near deadlines. @return when the wait ended
base::RunTime LinkLoop::wait(base::RunTime now) {
  poll_set_.clear();
  poll_set_.add(signal_.descriptor(), POLLIN);  // kSignalEntry
  poll_set_.add(alarm_.descriptor(), POLLIN);   // kAlarmEntry
  for (const Resident& resident : links_) resident.link->watch(poll_set_, now);
  end_turn();
  const base::RunTime due = poll_set_.deadline();
  if (const base::RunTime rested = std::min(pace_.next_look(), due); rested > now) {
    rest_until(rested, base::steady_now());
  }
  const base::RunTime began = base::steady_now();
  poll_until(due, now, began);
  begin_turn();
  // Only events seen by this poll: a signal raised since then is for the next turn.
  if ((poll_set_.revents(kSignalEntry) & POLLIN) != 0) {
    signal_.lower();
    has_tasks_ = true;
  }
  if ((poll_set_.revents(kAlarmEntry) & POLLIN) != 0) alarm_.stop();
  const base::RunTime ended = base::steady_now();
  idle_ += ended - began;
  return ended;
}

void LinkLoop::begin_turn() {
  if (meter_) meter_->begin();
}

void LinkLoop::end_turn() const {
  if (!meter_) return;
  const std::optional<std::string> fault = excess(meter_->end(), links_.size());
  if (!fault) return;
  base::log::error("links (" + name_ + "): one turn " + *fault);
  std::abort();
}

void LinkLoop::poll_until(base::RunTime due, base::RunTime now, base::RunTime began) {
  std::optional<timespec> limit;
  if (!alarm_.covers(due, now)) limit = until(due, began);
  const int error = poll_set_.wait(limit);
  if (error == 0) {
    in_trouble_ = false;
  } else if (error != EINTR) {
    wait_in_trouble(error);
  }
}

// Only the signal ends it early: somebody wants something of this thread.
void LinkLoop::rest_until(base::RunTime end, base::RunTime now) {
  pollfd signal{signal_.descriptor().get(), POLLIN, 0};
  const timespec timeout = until(end, now);
  ::ppoll(&signal, 1, &timeout, nullptr);
}

// The link that floods leaves those that it shares the thread with, and comes back in the end.
void LinkLoop::move_links(base::RunTime now) {
  if (pace_.flood_lasts() && links_.size() > 1) {
    const auto leaving = busiest();
    if (leaving->home == nullptr || !leaving->home->has_own_loop(now)) return;
    poll_set_.release();
    if (!leaving->home->take_flooding(leaving->link)) return;
    links_.erase(leaving);
    pace_ = LookPace();
    pace_.add_link(received());
  } else if (links_.size() == 1 && pace_.flood_is_over(now)) {
    Resident& visitor = links_.front();
    if (!visitor.visits) return;
    poll_set_.release();
    if (visitor.home->take_calm(visitor.link)) links_.clear();
  }
}

void LinkLoop::note_received() {
  for (Resident& resident : links_) resident.received = resident.link->received();
}

std::vector<LinkLoop::Resident>::iterator LinkLoop::busiest() {
  return std::max_element(links_.begin(), links_.end(), [](const Resident& a, const Resident& b) {
    return a.link->received() - a.received < b.link->received() - b.received;
  });
}

std::uint64_t LinkLoop::received() const {
  std::uint64_t sum = 0;
  for (const Resident& resident : links_) sum += resident.link->received();
  return sum;
}

Arrivals LinkLoop::arrivals() const {
  Arrivals sum;
  for (const Resident& resident : links_) {
    const Arrivals of_link = resident.link->arrivals();
    sum.packets += of_link.packets;
    sum.waited += of_link.waited;
  }
  return sum;
}

// Out of memory, or more descriptors than the limit allows: the next turn would fail at once too.
void LinkLoop::wait_in_trouble(int error) {
  if (!in_trouble_) {
    base::log::error(
        fmt::format("links ({}) cannot wait for their descriptors, trying again every {} ms: {}",
                    name_, kTroublePause.count(), base::error_text(error)));
  }
  in_trouble_ = true;
  std::this_thread::sleep_for(kTroublePause);
}

// Whoever has a task for the thread raises its signal after that.
void LinkLoop::run_tasks() {
  if (!std::exchange(has_tasks_, false)) return;
  const bool again = !taken_.empty();
  if (!again) {
    const base::MutexLock lock(tasks_mutex_);
    taken_.swap(tasks_);
  }
  std::erase_if(taken_,
                [this](const auto& task) { return base::outlive_lack_of_memory(name_, task); });
  if (!again && taken_.empty()) return;
  has_tasks_ = true;  // also of those that came meanwhile
  signal_.raise();
}

DistantAlarm::DistantAlarm()
    : timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)) {
  if (!timer_) throw base::ConfigError("no timer descriptor: too many open files");
  opened_ = OpenDescriptor(timer_.get());
}

bool DistantAlarm::covers(base::RunTime due, base::RunTime now) {
  if (due >= rings_at_) return true;
  if (due - now < kNear) return false;
  const itimerspec once{.it_interval = {}, .it_value = until(due, base::RunTime{})};
  if (::timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &once, nullptr) != 0) return false;
  rings_at_ = due;
  return true;
}

void DistantAlarm::stop() {
  std::uint64_t times = 0;
  [[maybe_unused]] const auto taken = ::read(timer_.get(), &times, sizeof times);
  rings_at_ = PollSet::kNever;
}

WakeSignal::WakeSignal() : event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!event_) throw base::ConfigError("no event descriptor: too many open files");
  opened_ = OpenDescriptor(event_.get());
}

void WakeSignal::raise() {
  if (raised_.exchange(true, std::memory_order_acq_rel)) return;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(event_.get(), &one, sizeof one);
}

void WakeSignal::lower() {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto taken = ::read(event_.get(), &count, sizeof count);
  raised_.exchange(false, std::memory_order_acq_rel);
}

}  // namespace cas::casd
