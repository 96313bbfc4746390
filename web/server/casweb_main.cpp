// SPDX-License-Identifier: BSD-3-Clause
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/cli/manual.hpp"
#include "base/cli/parse.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/command_port.hpp"
#include "base/os/host_port.hpp"
#include "base/os/log.hpp"
#include "base/os/notify.hpp"
#include "base/os/program.hpp"
#include "base/os/runtime_folder.hpp"
#include "base/os/thread.hpp"
#include "base/os/write_file.hpp"
#include "base/rpc/local_port.hpp"
#include "base/rpc/token.hpp"
#include "web/server/page_files.hpp"
#include "web/server/page_hub.hpp"
#include "web/server/web_server.hpp"

namespace {

using namespace cas;

constexpr const char* kTokenFile = "casweb.token";
constexpr const char* kHilsimSocket = "hilsim.sock";

struct Flags {
  std::string listen = "127.0.0.1:5791";
  std::vector<std::string> hosts;
  std::optional<std::filesystem::path> page;
  std::string casd;
  std::string hilsim;
  std::string hils;
  std::string token_file;
  std::string address_file;
  std::string log_level = "info";
  bool read_only = false;
};

void add_flags(CLI::App& app, Flags& flags) {
  app.add_option("--listen", flags.listen,
                 "Where to serve the page (127.0.0.1:5791); port 0 takes a free one. An address "
                 "that other machines reach needs --token-file");
  app.add_option("--host", flags.hosts,
                 "A further name that browsers reach this address by; several may be given");
  app.add_option("--page", flags.page, "Folder of the built page, instead of the installed one");
  app.add_option("--casd", flags.casd,
                 "Unix socket of casd; left out: of the one that runs on this machine");
  app.add_option("--hilsim", flags.hilsim,
                 "Control socket of hilsim (hilsim.sock in the runtime folder)");
  app.add_option("--hils", flags.hils,
                 "Socket of a run of hils, whose limits and reference are shown; hils run --web "
                 "gives it");
  app.add_option("--token-file", flags.token_file,
                 "File with the token of the address, for its owner alone; made where it is "
                 "missing (casweb.token in the runtime folder)");
  app.add_option("--address-file", flags.address_file,
                 "Write the address with its token into this file, for its owner alone");
  app.add_flag("--read-only", flags.read_only, "Show, and let nobody command anything");
  app.add_option("--log-level", flags.log_level, "Level: debug, info, warn, error or off");
  app.set_version_flag("--version", "casweb " CAS_VERSION);
  base::cli::add_manual(app, "casweb", CAS_VERSION);
}

struct Address {
  std::string host;
  std::uint16_t port = 0;
};

Address parse_listen(const std::string& text) {
  const auto parts = base::parse_host_port(text);
  const auto port = parts ? base::parse_port(parts->port) : std::nullopt;
  if (!port) throw base::ConfigError("--listen " + text + ": is not ADDRESS:PORT");
  return {parts->host, *port};
}

/// As a URL and a Host have it.
std::string in_url(const std::string& host) {
  return host.find(':') == std::string::npos ? host : "[" + host + "]";
}

/// The socket that a flag names, else the result of `find`.
web::Upstream::Find finder(std::string_view flag, web::Upstream::Find find) {
  if (flag.empty()) return find;
  constexpr std::string_view kUnix = "unix:";
  if (flag.starts_with(kUnix)) flag.remove_prefix(kUnix.size());
  return [path = std::filesystem::path(flag)] { return std::vector<std::filesystem::path>{path}; };
}

std::vector<std::filesystem::path> hilsim_sockets() {
  try {
    return {base::runtime_folder() / kHilsimSocket};
  } catch (const base::ConfigError&) {
    return {};  // another user's folder is at this user's path
  }
}

std::filesystem::path token_file(const Flags& flags, const Address& address) {
  if (!flags.token_file.empty()) return flags.token_file;
  if (!base::rpc::is_loopback_address(address.host)) {
    throw base::ConfigError("--listen " + flags.listen +
                            ": other machines reach it, so that --token-file must be given");
  }
  return base::rpc::make_runtime_folder() / kTokenFile;
}

/// The token is shown only on a terminal: a journal would keep it.
void tell_address(const std::string& url, const std::string& token,
                  const std::filesystem::path& file, const std::string& address_file) {
  const std::string whole = url + "#k=" + token;
  if (!address_file.empty()) {
    std::filesystem::remove(address_file);
    const mode_t before = ::umask(S_IRWXG | S_IRWXO);
    base::write_file(address_file, whole + "\n", base::Durability::kCache);
    ::umask(before);
  }
  if (::isatty(STDOUT_FILENO) != 0) {
    std::printf("%s\n", whole.c_str());
  } else {
    std::printf("%s (the token is in %s)\n", url.c_str(), file.c_str());
  }
  std::fflush(stdout);
}

int run(const Flags& flags) {
  const Address address = parse_listen(flags.listen);
  const web::PageFiles files(flags.page ? flags.page : base::web_dir());
  const std::filesystem::path secret = token_file(flags, address);
  base::rpc::make_token(secret);
  const std::string token = base::rpc::read_token(secret);

  boost::asio::io_context io(1);
  web::PageHub hub(io, {.find_casd = finder(flags.casd, base::rpc::local_command_sockets),
                        .find_hilsim = finder(flags.hilsim, hilsim_sockets),
                        .find_hils = finder(flags.hils, {})});
  web::WebServer server(io, hub, files, {.token = token, .read_only = flags.read_only});
  std::vector<std::string> names = flags.hosts;
  names.push_back(in_url(address.host));
  const std::uint16_t port =
      base::bind_command_port([&] { return server.listen(address.host, address.port, names); });

  boost::asio::signal_set signals(io, SIGINT, SIGTERM);
  signals.async_wait([&](const auto& error, int) {
    if (!error) io.stop();
  });
  hub.start();
  base::lower_this_thread("casweb");
  const std::string url = "http://" + in_url(address.host) + ":" + std::to_string(port) + "/";
  tell_address(url, token, secret, flags.address_file);
  base::notify("READY=1\nSTATUS=" + url);
  io.run();
  base::notify("STOPPING=1");
  server.close();
  hub.close();
  return base::kExitOk;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Serves the page that shows and commands a bench in a browser.", "casweb");
  Flags flags;
  add_flags(app, flags);
  if (const auto ended = base::cli::parse(app, argc, argv, base::kExitConfig)) return *ended;
  return base::run_program("casweb", flags.log_level, [&] { return run(flags); });
} catch (const std::exception& error) {  // no memory to read the command line
  std::fprintf(stderr, "casweb: internal error: %s\n", error.what());
  return base::kExitInternal;
}
