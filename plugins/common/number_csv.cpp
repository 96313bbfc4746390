// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/number_csv.hpp"

#include <fmt/format.h>
#include <cmath>

#include "base/byte_order_mark.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"

namespace cas::sim {

NumberCsv::NumberCsv(const std::filesystem::path& file, const std::string& kind,
                     std::size_t most_bytes, const std::string& header)
    : file_(file), stream_(base::read_foreign_file(file, kind, most_bytes)) {
  if (!read_line() || text_ != header) fail("the first line must be " + header);
}

bool NumberCsv::next(std::span<double> values) {
  do {
    if (!read_line()) return false;
  } while (text_.empty());
  std::istringstream words(text_);
  const auto wrong = [&] {
    fail(fmt::format("needs {} numbers with commas between them", values.size()));
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0 && words.get() != ',') wrong();
    if (!(words >> values[i]) || !std::isfinite(values[i])) wrong();
  }
  if (words.get() != std::istringstream::traits_type::eof()) wrong();
  return true;
}

void NumberCsv::fail(const std::string& sentence) const {
  throw base::ConfigError(fmt::format("{}:{}: {}", file_.string(), line_, sentence));
}

bool NumberCsv::read_line() {
  if (!std::getline(stream_, text_)) return false;
  ++line_;
  if (line_ == 1) text_.erase(0, text_.size() - base::without_byte_order_mark(text_).size());
  if (!text_.empty() && text_.back() == '\r') text_.pop_back();
  return true;
}

}  // namespace cas::sim
