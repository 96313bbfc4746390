// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/rpc/message.hpp"
#include "base/time/clock.hpp"
#include "web/server/upstream.hpp"

namespace cas::web {

class PageClient;

/// State shared by all pages: the connections to casd, hilsim and the run of hils, samples of each
/// topic, events.
///
///   page waits for a topic --> timer of its rate --> one question --> snapshot to all that wait
///
/// A topic for which no page waits is not asked for. Everything on the thread of `io`.
class PageHub {
 public:
  struct Config {
    Upstream::Find find_casd;
    Upstream::Find find_hilsim;
    Upstream::Find find_hils{};  ///< empty: no run is shown
  };

  /// Shared by all to whom they are sent.
  using Bytes = std::shared_ptr<const std::string>;
  using TakeMesh = std::function<void(const Bytes& bytes)>;

  PageHub(boost::asio::io_context& io, Config config);
  ~PageHub();
  PageHub(const PageHub&) = delete;
  PageHub& operator=(const PageHub&) = delete;

  void start();
  void close();

  Upstream& casd();
  Upstream& hilsim();
  /// The run of hils that is shown; nullptr where none is.
  Upstream* hils();

  /// A page that has said hello gets events and the topics it waits for, until it is gone.
  void add(const std::shared_ptr<PageClient>& client);
  /// Highest rate of a topic, Hz; nullopt for one that there is not.
  std::optional<double> rate_of(const std::string& topic) const;
  /// Some page waits for this topic.
  void on_wanted(const std::string& topic);

  /// Answer to `hello`, without the page's own part.
  base::rpc::Json greeting() const;
  /// Answer to `bench.status`.
  base::rpc::Json bench_status() const;
  /// A mesh of hilsim's scene: its bytes, or nothing if there is none or it has over 64 MiB.
  /// Requests for a pending mesh share its answer.
  void fetch_mesh(const std::string& hash, TakeMesh take);
  /// Whether a further page may be greeted.
  bool has_place() const;
  /// Whether the pages together may watch that many more fields.
  bool has_room_for(std::size_t fields) const;
  /// The page that may move the sticks of a vehicle. @return whether it is `client` now
  bool take_pilot(std::uint64_t client, int system, base::RunTime now);
  /// Whether it still is; a stick keeps it.
  bool is_pilot(std::uint64_t client, int system, base::RunTime now);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cas::web
