// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/request_chain.hpp"

#include <cstddef>
#include <memory>
#include <utility>

namespace cas::casd {
namespace {

struct Chain {
  std::vector<Request> requests;
  Done done;
  std::size_t next = 0;
  Outcome total{};
};

void run_next(const std::shared_ptr<Chain>& chain) {
  Outcome& total = chain->total;
  if (!total.ok() || chain->next == chain->requests.size()) return chain->done(total);
  chain->requests[chain->next++]([chain, &total](const Outcome& outcome) {
    total.kind = outcome.kind;
    total.message = outcome.message;
    for (const auto& [name, value] : outcome.parameters) total.parameters[name] = value;
    for (const auto& [name, value] : outcome.before) total.before[name] = value;
    for (const std::string& text : outcome.status_texts) total.status_texts.push_back(text);
    run_next(chain);
  });
}

}  // namespace

void run_chain(std::vector<Request> requests, Done done) {
  run_next(
      std::make_shared<Chain>(Chain{.requests = std::move(requests), .done = std::move(done)}));
}

}  // namespace cas::casd
