// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <utility>

namespace cas::web {

/// Places of connections that have not proved the token. When all are taken the oldest connection
/// gives way to the new one, so that idle connections lock no one out.
class StrangerPlaces {
 public:
  struct Place {
    std::function<void()> leave;  ///< ends the connection
  };

  explicit StrangerPlaces(std::size_t most) : most_(most) {}

  /// A place, held while it lives.
  std::shared_ptr<Place> take(std::function<void()> leave) {
    std::erase_if(taken_, [](const std::weak_ptr<Place>& place) { return place.expired(); });
    if (taken_.size() >= most_) {
      const auto oldest = taken_.front().lock();
      taken_.pop_front();
      oldest->leave();
    }
    auto place = std::make_shared<Place>(Place{std::move(leave)});
    taken_.push_back(place);
    return place;
  }

 private:
  std::size_t most_;
  std::list<std::weak_ptr<Place>> taken_;  // in the order in which they came
};

}  // namespace cas::web
