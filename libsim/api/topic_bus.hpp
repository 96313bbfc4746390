// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.hpp"

namespace cas::sim {

namespace detail {

/// One topic: its declared type and its subscribers in the order in which they came.
struct Topic {
  std::string name;
  std::string type;
  unsigned version = 0;
  bool advertised = false;
  bool needed = false;  ///< some subscriber requires it
  std::vector<std::pair<std::uint64_t, std::function<void(const void*)>>> subscribers;
  std::uint64_t next_id = 0;
  std::function<void(const void*)> interceptor;  ///< if set, gets all messages

  void deliver(const void* value) const {
    for (const auto& [id, on_message] : subscribers) on_message(value);
  }
};

}  // namespace detail

/// Whether a subscriber can do without the topic's publisher: unpublished() names those it cannot.
enum class Need { kRequired, kOptional };

/// Publishes on one topic: a direct call of each subscriber, on the simulation thread.
template <class T>
class Publisher {
 public:
  Publisher() = default;
  explicit Publisher(std::shared_ptr<detail::Topic> topic) : topic_(std::move(topic)) {}

  /// Calls every subscriber with `value`, in the order in which they subscribed, before it returns.
  void publish(const T& value) const {
    if (topic_->interceptor) return topic_->interceptor(&value);
    topic_->deliver(&value);
  }
  /// Whether the topic has subscribers; without them its message need not be computed.
  bool has_subscribers() const { return topic_ && !topic_->subscribers.empty(); }

 private:
  std::shared_ptr<detail::Topic> topic_;
};

/// Sits between the publisher of one topic and its subscribers (faults, recorded data): published
/// messages reach only the interceptor, which decides which to deliver, and when.
template <class T>
class Interceptor {
 public:
  Interceptor() = default;
  explicit Interceptor(std::shared_ptr<detail::Topic> topic) : topic_(std::move(topic)) {}
  Interceptor(Interceptor&&) noexcept = default;
  Interceptor& operator=(Interceptor&& other) noexcept {
    std::swap(topic_, other.topic_);
    return *this;
  }
  ~Interceptor() {
    if (topic_) topic_->interceptor = nullptr;
  }

  /// Calls the subscribers, as publish() does without an interceptor.
  void deliver(const T& value) const { topic_->deliver(&value); }

 private:
  std::shared_ptr<detail::Topic> topic_;
};

/// A subscriber's hold on a topic, from TopicBus::subscribe(): the subscription ends when this is
/// destroyed. Plugins keep it as a member.
class Subscription {
 public:
  Subscription() = default;
  Subscription(std::shared_ptr<detail::Topic> topic, std::uint64_t id)
      : topic_(std::move(topic)), id_(id) {}
  Subscription(Subscription&&) noexcept = default;
  Subscription& operator=(Subscription&& other) noexcept {
    std::swap(topic_, other.topic_);
    std::swap(id_, other.id_);
    return *this;
  }
  ~Subscription() {
    if (topic_)
      std::erase_if(topic_->subscribers, [this](const auto& s) { return s.first == id_; });
  }

 private:
  std::shared_ptr<detail::Topic> topic_;
  std::uint64_t id_ = 0;
};

/// Publish and subscribe between plugins ([HILS] Fig. 6). Wiring is legal until `freeze()`;
/// delivery is a direct call in subscription order: deterministic, without lock or copy. One
/// thread. SimRunner owns the bus; plugins reach it by PluginContext::bus().
///
///   configure():  imu_ = bus.advertise<ImuSample>("iris0/imu");                 // plugin imu
///                 sensor_ = bus.subscribe<ImuSample>("iris0/imu", on_imu);      // a reader
///   SimRunner:    bus.freeze();
///   post_step():  imu_.publish(sample);                                         // calls on_imu
class TopicBus {
 public:
  /// The right to publish on a topic.
  /// @throws base::ConfigError when the topic has a publisher, another type, or the bus is frozen
  template <class T>
  [[nodiscard]] Publisher<T> advertise(const std::string& name) {
    auto topic = find_or_add(name, T::kTypeName, T::kTypeVersion);
    if (topic->advertised) throw base::ConfigError("topic '" + name + "' has two publishers");
    topic->advertised = true;
    return Publisher<T>(std::move(topic));
  }

  /// `on_message(const T&)` runs inside publish().
  /// @throws base::ConfigError when the topic has another type or the bus is frozen
  template <class T>
  [[nodiscard]] Subscription subscribe(const std::string& name,
                                       std::function<void(const T&)> on_message,
                                       Need need = Need::kRequired) {
    auto topic = find_or_add(name, T::kTypeName, T::kTypeVersion);
    topic->needed |= need == Need::kRequired;
    const std::uint64_t id = topic->next_id++;
    topic->subscribers.emplace_back(id, [callback = std::move(on_message)](const void* value) {
      callback(*static_cast<const T*>(value));
    });
    return Subscription(std::move(topic), id);
  }

  /// `on_publish(const T&)` runs inside publish() in place of the subscribers.
  /// @throws base::ConfigError when the topic has an interceptor, and as subscribe()
  template <class T>
  [[nodiscard]] Interceptor<T> intercept(const std::string& name,
                                         std::function<void(const T&)> on_publish) {
    auto topic = find_or_add(name, T::kTypeName, T::kTypeVersion);
    if (topic->interceptor) throw base::ConfigError("topic '" + name + "' is intercepted twice");
    topic->interceptor = [callback = std::move(on_publish)](const void* value) {
      callback(*static_cast<const T*>(value));
    };
    return Interceptor<T>(std::move(topic));
  }

  /// Ends the wiring: from now on advertise(), subscribe() and intercept() throw.
  void freeze() { frozen_ = true; }

  /// Whether a plugin that was configured before has the right to publish on a topic.
  bool is_advertised(const std::string& name) const {
    const auto topic = topics_.find(name);
    return topic != topics_.end() && topic->second->advertised;
  }

  /// Required topics without a publisher, for a warning in the log.
  std::vector<std::string> unpublished() const {
    std::vector<std::string> names;
    for (const auto& [name, topic] : topics_) {
      if (!topic->advertised && topic->needed) names.push_back(name);
    }
    return names;
  }

 private:
  std::shared_ptr<detail::Topic> find_or_add(const std::string& name, std::string_view type,
                                             unsigned version) {
    if (frozen_) throw base::ConfigError("topic '" + name + "' is wired after configure");
    auto& topic = topics_[name];
    if (!topic) {
      topic = std::make_shared<detail::Topic>();
      topic->name = name;
      topic->type = type;
      topic->version = version;
    }
    if (topic->type != type || topic->version != version) {
      throw base::ConfigError("topic '" + name + "' carries " + topic->type + " version " +
                              std::to_string(topic->version) + ", not " + std::string(type) +
                              " version " + std::to_string(version));
    }
    return topic;
  }

  std::map<std::string, std::shared_ptr<detail::Topic>> topics_;
  bool frozen_ = false;
};

}  // namespace cas::sim
