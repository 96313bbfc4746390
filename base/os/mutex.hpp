// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <shared_mutex>

// Annotations that name the lock of each member. Clang checks it (-Wthread-safety); other compilers
// ignore it.
#ifdef __clang__
#define CAS_THREAD_SAFETY(attribute) __attribute__((attribute))
#else
#define CAS_THREAD_SAFETY(attribute)
#endif
/// A member that is touched only while the lock is held.
#define CAS_GUARDED_BY(lock) CAS_THREAD_SAFETY(guarded_by(lock))
/// A function that is called only while the lock is held.
#define CAS_REQUIRES(lock) CAS_THREAD_SAFETY(requires_capability(lock))
/// The caller holds this shared mutex at least for reading (SharedLock).
#define CAS_REQUIRES_SHARED(lock) CAS_THREAD_SAFETY(requires_shared_capability(lock))

namespace cas::base {

/// std::mutex, known to the analysis.
class CAS_THREAD_SAFETY(capability("mutex")) Mutex {
 public:
  void lock() CAS_THREAD_SAFETY(acquire_capability()) { mutex_.lock(); }
  void unlock() CAS_THREAD_SAFETY(release_capability()) { mutex_.unlock(); }
  bool try_lock() CAS_THREAD_SAFETY(try_acquire_capability(true)) { return mutex_.try_lock(); }

 private:
  std::mutex mutex_;
};

/// Holds a mutex as long as it lives. std::condition_variable_any waits with it, too.
class CAS_THREAD_SAFETY(scoped_lockable) MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) CAS_THREAD_SAFETY(acquire_capability(mutex)) : mutex_(mutex) {
    mutex_.lock();
  }
  /// Takes over a mutex that try_lock() has locked.
  MutexLock(Mutex& mutex, std::adopt_lock_t /*locked*/) CAS_REQUIRES(mutex) : mutex_(mutex) {}
  ~MutexLock() CAS_THREAD_SAFETY(release_capability()) { mutex_.unlock(); }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

  void lock() CAS_THREAD_SAFETY(acquire_capability()) { mutex_.lock(); }
  void unlock() CAS_THREAD_SAFETY(release_capability()) { mutex_.unlock(); }

 private:
  Mutex& mutex_;
};

/// std::shared_mutex, known to the analysis.
class CAS_THREAD_SAFETY(capability("mutex")) SharedMutex {
 public:
  void lock() CAS_THREAD_SAFETY(acquire_capability()) { mutex_.lock(); }
  void unlock() CAS_THREAD_SAFETY(release_capability()) { mutex_.unlock(); }
  void lock_shared() CAS_THREAD_SAFETY(acquire_shared_capability()) { mutex_.lock_shared(); }
  void unlock_shared() CAS_THREAD_SAFETY(release_shared_capability()) { mutex_.unlock_shared(); }

 private:
  std::shared_mutex mutex_;
};

/// Holds a SharedMutex alone, for a writer, as long as it lives.
class CAS_THREAD_SAFETY(scoped_lockable) ExclusiveLock {
 public:
  explicit ExclusiveLock(SharedMutex& mutex) CAS_THREAD_SAFETY(acquire_capability(mutex))
      : lock_(mutex) {}
  ~ExclusiveLock() CAS_THREAD_SAFETY(release_capability()) {}

 private:
  std::scoped_lock<SharedMutex> lock_;
};

/// Holds a SharedMutex together with other readers, as long as it lives.
class CAS_THREAD_SAFETY(scoped_lockable) SharedLock {
 public:
  explicit SharedLock(SharedMutex& mutex) CAS_THREAD_SAFETY(acquire_shared_capability(mutex))
      : lock_(mutex) {}
  ~SharedLock() CAS_THREAD_SAFETY(release_capability()) {}

 private:
  std::shared_lock<SharedMutex> lock_;
};

}  // namespace cas::base
