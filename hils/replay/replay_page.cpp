// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/replay_page.hpp"

#include <zlib.h>

#include <array>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"
#include "base/rpc/base64.hpp"
#include "hils/programs/web_view.hpp"
#include "hils/replay/run_settings.hpp"

namespace cas::hils {

namespace {

constexpr int kGzip = 16 + MAX_WBITS;                         // a gzip header, not zlib's
constexpr std::size_t kMaxPageBytes = std::size_t{1} << 30U;  // inflated
constexpr std::string_view kPlace = "<!--RECORDS-->";

std::filesystem::path template_file() {
  const auto folder = base::web_dir();
  if (!folder || !std::filesystem::exists(*folder / "replay.html")) {
    throw base::ConfigError(why_no_page());
  }
  return *folder / "replay.html";
}

/// Inflates part by part. @throws base::ConfigError as check_gzip() does
void inflate_record(std::string_view bytes, const std::function<void(std::string_view)>& take) {
  z_stream stream{};
  if (inflateInit2(&stream, kGzip) != Z_OK) throw base::ConfigError("zlib cannot begin to read");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));  // zlib only reads it
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::array<char, 65536> part{};
  int state = Z_OK;
  while (state == Z_OK && stream.total_out <= kMaxPageBytes) {
    stream.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.avail_out = static_cast<uInt>(part.size());
    state = inflate(&stream, Z_NO_FLUSH);
    take({part.data(), part.size() - stream.avail_out});
  }
  const bool too_large = stream.total_out > kMaxPageBytes;
  inflateEnd(&stream);
  if (too_large) throw base::ConfigError("this is no record: it inflates to over 1 GiB");
  if (state != Z_STREAM_END) throw base::ConfigError("this is no record: it is not gzip, or cut");
}

/// A run's folder or a log with the settings that it flew with: base 64 of ASCII JSON.
std::string source_attribute(const std::filesystem::path& source) {
  const nlohmann::json json{{"path", source.lexically_normal().string()},
                            {"settings", run_settings(source)}};
  return base::rpc::to_base64(json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
}

}  // namespace

std::string gzip(std::string_view text) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, MAX_MEM_LEVEL,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw base::ConfigError("zlib cannot begin to compress");
  }
  std::string bytes(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // zlib only reads it
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  const int end = deflate(&stream, Z_FINISH);
  bytes.resize(stream.total_out);
  deflateEnd(&stream);
  if (end != Z_STREAM_END) throw base::ConfigError("zlib could not compress a record");
  return bytes;
}

void check_gzip(std::string_view bytes) {
  inflate_record(bytes, [](std::string_view) {});
}

std::string gunzip(std::string_view bytes) {
  std::string text;
  inflate_record(bytes, [&text](std::string_view part) { text += part; });
  return text;
}

std::string replay_page(std::span<const std::string> records,
                        std::span<const std::filesystem::path> sources) {
  const std::filesystem::path file = template_file();
  std::string page = base::read_file(file).value_or("");
  const std::size_t place = page.find(kPlace);
  if (place == std::string::npos) {
    throw base::ConfigError(file.string() + ": not the page of CAS: it has no place for records");
  }
  std::string blocks;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const std::string source =
        sources.empty() ? "" : " data-source=\"" + source_attribute(sources[i]) + "\"";
    blocks += "<script type=\"application/octet-stream\" class=\"record\"" + source + ">" +
              base::rpc::to_base64(records[i]) + "</script>\n";
  }
  return page.replace(place, kPlace.size(), blocks);
}

bool has_page() {
  const auto folder = base::web_dir();
  return folder && std::filesystem::exists(*folder / "replay.html");
}

std::string why_no_page() { return "no replay.html: " + built_without_page(); }

std::filesystem::path record_file(const std::filesystem::path& out) {
  return out / "run" / "record.json.gz";
}

}  // namespace cas::hils
