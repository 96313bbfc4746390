// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <pwd.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <random>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/os/file_lock.hpp"
#include "base/read_file.hpp"
#include "hils/boards/board_error.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

constexpr const char* kHolderVariable = "CAS_BOARD_HOLDER";
constexpr mode_t kOfTheGroup = 0660;  ///< several users may share a folder
constexpr int kLookMs = 100;

[[noreturn]] void fail_lock(const fs::path& file) {
  throw base::ConfigError(file.string() + ": " + base::error_text(errno));
}

fs::path place(const fs::path& folder, const Board& board, const char* kind) {
  std::string name = board.identity();
  std::ranges::replace_if(
      name, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '.'; }, '_');
  return folder / (name + kind);
}

fs::path guests_file(const fs::path& folder, const Board& board) {
  return place(folder, board, ".guests");
}

fs::path queue_of(const fs::path& folder, const Board& board) {
  return place(folder, board, ".queue");
}

base::Descriptor open_for_lock(const fs::path& file) {
  constexpr int kFlags = O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
  // With O_CREAT the kernel may refuse another user's file in a sticky folder.
  base::Descriptor fd(::open(file.c_str(), kFlags));
  if (!fd && errno == ENOENT) {
    fd = base::Descriptor(::open(file.c_str(), kFlags | O_CREAT, kOfTheGroup));
    if (fd) ::fchmod(fd.get(), kOfTheGroup);  // whatever the umask is
  }
  if (!fd) fail_lock(file);
  struct stat status {};
  const bool is_lock =
      ::fstat(fd.get(), &status) == 0 && S_ISREG(status.st_mode) && status.st_nlink == 1;
  if (!is_lock) throw base::ConfigError(file.string() + ": is no lock");
  return fd;
}

std::optional<LockHolder> read_holder(int lock) {
  std::string text(65536, '\0');
  const ssize_t size = ::pread(lock, text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  return LockHolder::parse(text);
}

/// A file that another user may have laid; a FIFO does not block.
base::Descriptor open_to_look(const fs::path& file) {
  constexpr int kFlags = O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
  return base::Descriptor(::open(file.c_str(), kFlags));
}

std::string user_name() {
  const passwd* entry = ::getpwuid(::getuid());
  return entry == nullptr ? std::to_string(::getuid()) : entry->pw_name;
}

std::string random_token() {
  std::random_device source;
  return fmt::format("{:08x}{:08x}{:08x}", source(), source(), source());
}

bool take_shared_lock(int fd) {
  struct flock lock = base::whole_file(F_RDLCK);
  return ::fcntl(fd, F_OFD_SETLK, &lock) == 0;
}

void free_file_lock(int fd) {
  struct flock lock = base::whole_file(F_UNLCK);
  ::fcntl(fd, F_OFD_SETLK, &lock);
}

/// Whether the path still names this file: the folder may be deleted during the wait.
bool is_in_place(int fd, const fs::path& file) {
  struct stat own {};
  struct stat there {};
  return ::fstat(fd, &own) == 0 && ::stat(file.c_str(), &there) == 0 &&
         own.st_dev == there.st_dev && own.st_ino == there.st_ino;
}

/// Whether a guest is at work.
bool is_shared(const fs::path& guests) {
  const base::Descriptor file = open_to_look(guests);
  struct flock lock = base::whole_file(F_WRLCK);
  return file && ::fcntl(file.get(), F_OFD_GETLK, &lock) == 0 && lock.l_type == F_RDLCK;
}

/// Takes a board that is free: no holder, no guest.
bool take_both(int lock, int guests) {
  if (!base::take_file_lock(lock)) return false;
  if (base::take_file_lock(guests)) return true;
  free_file_lock(lock);
  return false;
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

/// The queue's folder itself: tickets are cleared away there, and behind a symlink are files of
/// somebody else.
base::Descriptor open_queue(const fs::path& queue) {
  return base::Descriptor(::open(queue.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
}

/// A path that leads to the open folder, whatever has its name now.
fs::path path_of(const base::Descriptor& folder) {
  return fmt::format("/proc/self/fd/{}", folder.get());
}

/// Tickets of waiters that are still there; those of others are cleared away.
std::vector<std::string> living_tickets(const fs::path& queue) {
  std::vector<std::string> alive;
  const base::Descriptor folder = open_queue(queue);
  if (!folder) return alive;
  std::error_code error;
  for (fs::directory_iterator at(path_of(folder), error); !error && at != fs::directory_iterator();
       at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (name.starts_with(".")) continue;  // its lock is not taken yet
    const base::Descriptor ticket = open_to_look(at->path());
    struct stat status {};
    if (!ticket || ::fstat(ticket.get(), &status) != 0 || !S_ISREG(status.st_mode)) continue;
    if (base::is_file_locked(ticket.get())) {
      alive.push_back(name);
    } else {
      ::unlink(at->path().c_str());
    }
  }
  return alive;
}

/// Makes the queue's folder for the group. It is sticky, so that a user removes own tickets only.
void make_queue(const fs::path& queue) {
  if (::mkdir(queue.c_str(), 0700) != 0) return;
  struct stat made {};
  if (::stat(queue.c_str(), &made) != 0) return;
  ::chmod(queue.c_str(), S_ISVTX | (made.st_mode & S_ISGID) | 0770);
}

/// A place in the queue while the object is there.
class Ticket {
 public:
  explicit Ticket(const fs::path& queue) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    name_ = ticket_name(std::chrono::nanoseconds(now).count(), ::getpid());
    make_queue(queue);
    queue_ = open_queue(queue);
    if (!queue_) fail_lock(queue);
    file_ = path_of(queue_) / name_;
    // Others see it once its lock is taken: before, they would clear it away.
    const fs::path hidden = path_of(queue_) / ("." + name_);
    lock_ = open_for_lock(hidden);
    if (!base::take_file_lock(lock_.get()) || ::rename(hidden.c_str(), file_.c_str()) != 0) {
      fail_lock(hidden);
    }
  }
  ~Ticket() { ::unlink(file_.c_str()); }
  Ticket(const Ticket&) = delete;
  Ticket& operator=(const Ticket&) = delete;

  const std::string& name() const { return name_; }

 private:
  std::string name_;
  base::Descriptor queue_;
  fs::path file_;
  base::Descriptor lock_;
};

[[noreturn]] void refuse(const Board& board, const LockState& state, const std::string& how_long) {
  throw BoardError(kExitBoardBusy, fmt::format("board '{}' is not free{}: {}", board.name, how_long,
                                               to_words(state)));
}

/// Waits in the queue until it has the lock. @throws BoardError
void wait_for(int lock, int guests, const Board& board, const fs::path& folder,
              base::Duration patience) {
  const base::RunTime begin = base::steady_now();
  const fs::path queue = queue_of(folder, board);
  const Ticket ticket(queue);
  bool told = false;
  while (places_before(living_tickets(queue), ticket.name()) > 0 || !take_both(lock, guests)) {
    const LockState state = look_at_lock(board, folder);
    if (base::steady_now() - begin >= patience) {
      refuse(board, state, fmt::format(" after {:g} s", base::to_seconds(patience)));
    }
    if (!std::exchange(told, true)) {
      fmt::print(stderr, "hils: waiting for board '{}': {}\n", board.name, to_words(state));
    }
    ::poll(nullptr, 0, kLookMs);
  }
}

/// Whether a process has a file open by which its lock was taken, as far as can be seen: one that
/// waits for the lock has it open, too.
bool has_locked(pid_t process, const fs::path& file) {
  return std::ranges::any_of(descriptors_of(process, file), [process](int fd) {
    const auto text = base::read_file(fmt::format("/proc/{}/fdinfo/{}", process, fd));
    return text && text->find("\nlock:") != std::string::npos;
  });
}

/// The kernel's name of it, without control characters.
std::string name_of(pid_t process) {
  std::string name;
  std::ifstream in(fmt::format("/proc/{}/comm", process));
  std::getline(in, name);
  std::ranges::replace_if(
      name, [](unsigned char c) { return std::iscntrl(c) != 0; }, '?');
  return name;
}

std::string left_words(const LockState& state) {
  return fmt::format("process {} of {} has ended; what it started holds it since {}: {}",
                     state.holder->pid, state.holder->user, state.holder->since,
                     fmt::join(state.heirs, ", "));
}

}  // namespace

std::string holder_setting() {
  const char* tokens = std::getenv(kHolderVariable);
  return fmt::format("{}={}", kHolderVariable, tokens == nullptr ? "" : tokens);
}

fs::path lock_file(const fs::path& folder, const Board& board) {
  return place(folder, board, ".lock");
}

std::vector<int> descriptors_of(pid_t process, const fs::path& file) {
  std::vector<int> found;
  struct stat wanted {};
  if (::stat(file.c_str(), &wanted) != 0) return found;
  std::error_code error;
  for (fs::directory_iterator at(fmt::format("/proc/{}/fd", process), error);
       !error && at != fs::directory_iterator(); at.increment(error)) {
    struct stat its {};
    if (::stat(at->path().c_str(), &its) != 0) continue;
    if (its.st_dev == wanted.st_dev && its.st_ino == wanted.st_ino) {
      found.push_back(std::stoi(at->path().filename().string()));
    }
  }
  return found;
}

std::vector<std::string> who_has_locked(const Board& board, const fs::path& folder) {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator at("/proc", error); !error && at != fs::directory_iterator();
       at.increment(error)) {
    const pid_t process = std::atoi(at->path().filename().c_str());
    if (process <= 0) continue;
    const bool holds = has_locked(process, lock_file(folder, board)) ||
                       has_locked(process, guests_file(folder, board));
    if (holds) found.push_back(fmt::format("process {} ({})", process, name_of(process)));
  }
  return found;
}

fs::path own_lock_folder(const fs::path& parent) {
  const fs::path folder = parent / fmt::format("cas-boards-{}", ::getuid());
  ::mkdir(folder.c_str(), 0700);
  struct stat status {};
  const bool there = ::lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode);
  if (!there || status.st_uid != ::getuid() || (status.st_mode & 077) != 0) {
    throw base::ConfigError(folder.string() +
                            " is no private folder of yours (mode 0700); give boards.yaml a "
                            "lock_folder");
  }
  return folder;
}

fs::path lock_folder(const BoardList& list) {
  if (list.lock_folder.empty()) return own_lock_folder("/var/tmp");
  const fs::path& folder = list.lock_folder;
  std::error_code error;
  fs::create_directories(fs::absolute(folder).parent_path(), error);
  constexpr mode_t kStickyFolder = S_ISVTX | 0777;  // masked by the process's umask
  if (error || (::mkdir(folder.c_str(), kStickyFolder) != 0 && errno != EEXIST)) {
    const std::string why = error ? error.message() : base::error_text(errno);
    throw base::ConfigError(folder.string() + ": cannot be made: " + why);
  }
  constexpr mode_t kOthersWrite = S_IWGRP | S_IWOTH;
  struct stat status {};
  const bool known = ::stat(folder.c_str(), &status) == 0;
  if (known && (status.st_mode & kOthersWrite) != 0 && (status.st_mode & S_ISVTX) == 0) {
    throw base::ConfigError(folder.string() +
                            ": others may delete locks there; make it sticky (chmod +t)");
  }
  return folder;
}

LockState look_at_lock(const Board& board, const fs::path& folder) {
  LockState state;
  const fs::path file = lock_file(folder, board);
  const base::Descriptor lock = open_to_look(file);
  state.waiting = living_tickets(queue_of(folder, board)).size();
  state.held = lock && base::is_file_locked(lock.get());
  if (state.held) state.holder = read_holder(lock.get());
  state.has_guests = is_shared(guests_file(folder, board));
  state.held = state.held || state.has_guests;
  const bool gone = state.holder && ::kill(state.holder->pid, 0) != 0 && errno == ESRCH;
  if (gone) state.heirs = who_has_locked(board, folder);
  return state;
}

std::string to_words(const LockState& state) {
  if (!state.held) return state.waiting == 0 ? "it is free" : "it goes to who waits for it";
  std::string words = !state.heirs.empty() ? left_words(state)
                      : state.holder       ? "it is held by " + to_words(*state.holder)
                      : state.has_guests   ? "it is in use below a lock that has ended"
                                           : "it is held by a program that has just taken it";
  if (state.waiting > 0) words += fmt::format("; {} in the queue", state.waiting);
  return words;
}

BoardLock::BoardLock(const Board& board, const fs::path& folder, const std::string& purpose,
                     std::optional<base::Duration> wait) {
  if (become_guest(board, folder)) return;
  base::Descriptor guests;
  do {
    lock_ = open_for_lock(lock_file(folder, board));
    guests = open_for_lock(guests_file(folder, board));
    if (wait) {
      wait_for(lock_.get(), guests.get(), board, folder, *wait);
    } else if (look_at_lock(board, folder).waiting > 0 || !take_both(lock_.get(), guests.get())) {
      refuse(board, look_at_lock(board, folder), "");
    }
  } while (!is_in_place(lock_.get(), lock_file(folder, board)) ||
           !is_in_place(guests.get(), guests_file(folder, board)));
  const std::string token = random_token();
  holder_ = {.pid = ::getpid(),
             .user = user_name(),
             .since = utc_now(),
             .purpose = purpose,
             .token = proof_of(token)};
  write();
  const char* others = std::getenv(kHolderVariable);
  const bool any = others != nullptr && *others != 0;
  ::setenv(kHolderVariable, (any ? std::string(others) + "," + token : token).c_str(), 1);
}

/// Programs that a guest starts do not hold the board: a hook may leave one behind.
bool BoardLock::become_guest(const Board& board, const fs::path& folder) {
  const fs::path file = lock_file(folder, board);
  const auto is_invited = [&] {
    const LockState state = look_at_lock(board, folder);
    return state.holder && names_token(std::getenv(kHolderVariable), state.holder->token);
  };
  if (!is_invited()) return false;
  guest_ = open_for_lock(guests_file(folder, board));
  // The holder may have ended meanwhile; the second lock keeps others from taking the board.
  if (!take_shared_lock(guest_.get()) || !is_invited()) {
    guest_.reset();
    return false;
  }
  for (const int inherited : descriptors_of(::getpid(), file)) {
    ::fcntl(inherited, F_SETFD, FD_CLOEXEC);
  }
  return true;
}

BoardLock::~BoardLock() {
  if (!lock_ || handed_over_) return;
  // If it fails, the text does no harm: without the lock it is not believed.
  [[maybe_unused]] const int result = ::ftruncate(lock_.get(), 0);
}

void BoardLock::hand_over(pid_t child) {
  if (!lock_) return;
  holder_.pid = child;
  holder_.in_background = true;
  write();
  handed_over_ = true;
}

void BoardLock::write() const {
  const std::string text = holder_.text();
  const bool whole =
      ::ftruncate(lock_.get(), 0) == 0 &&
      ::pwrite(lock_.get(), text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
  if (!whole) throw base::ConfigError("the holder of a board cannot be written down");
}

}  // namespace cas::hils
