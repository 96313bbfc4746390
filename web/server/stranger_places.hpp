// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <utility>

namespace cas::web {

/// Places of connections that have not proved the token. When all are taken one gives way to the
/// new one, so that idle connections lock no one out: the oldest silent one, else the oldest.
class StrangerPlaces {
 public:
  struct Place {
    std::function<void()> leave;  ///< ends the connection
    bool spoke = false;           ///< its request is being answered, or it is a WebSocket
  };

  explicit StrangerPlaces(std::size_t most) : most_(most) {}

  /// A place, held while it lives.
  std::shared_ptr<Place> take(std::function<void()> leave) {
    std::erase_if(taken_, [](const std::weak_ptr<Place>& place) { return place.expired(); });
    if (taken_.size() >= most_) free_one();
    auto place = std::make_shared<Place>(Place{std::move(leave)});
    taken_.push_back(place);
    return place;
  }

 private:
  void free_one() {
    auto leaving = std::ranges::find_if(
        taken_, [](const std::weak_ptr<Place>& place) { return !place.lock()->spoke; });
    if (leaving == taken_.end()) leaving = taken_.begin();
    const auto place = leaving->lock();
    taken_.erase(leaving);
    place->leave();
  }

  std::size_t most_;
  std::list<std::weak_ptr<Place>> taken_;  // in the order in which they came
};

}  // namespace cas::web
