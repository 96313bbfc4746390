// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/recorder/csv_writer.hpp"

#include <array>
#include <charconv>
#include <utility>

#include "base/error.hpp"

namespace cas::sim {
namespace {

constexpr std::size_t kNumberBytes = 32;  // the longest double takes 24
constexpr std::size_t kMaxColumns = 64;

}  // namespace

CsvWriter::CsvWriter(base::ResultPlace place, std::string_view header)
    : file_(base::open_result(place)), place_(std::move(place)) {
  std::fwrite(header.data(), 1, header.size(), file_.get());
  std::fputc('\n', file_.get());
}

void CsvWriter::row(std::span<const double> values) {
  CAS_CHECK(values.size() <= kMaxColumns);
  std::array<char, kNumberBytes * kMaxColumns> text;
  char* end = text.data();
  for (const double value : values) {
    end = std::to_chars(end, end + kNumberBytes, value + 0.0).ptr;  // + 0.0: no "-0"
    *end++ = ',';
  }
  end[-1] = '\n';
  std::fwrite(text.data(), 1, static_cast<std::size_t>(end - text.data()), file_.get());
}

void CsvWriter::close() {
  if (file_) base::close_result(std::move(file_), place_);
}

}  // namespace cas::sim
