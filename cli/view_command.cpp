// `arkmesh view`: the page of a lab that runs, on another machine of the lab, or of recorded runs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/live/bus_view.hpp"
#include "app/live/federation_view.hpp"
#include "app/live/view_identity.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/page_opener.hpp"
#include "hal/config/config.hpp"
#include "hal/time/loop_time.hpp"
#include "recording/view/recorded_view.hpp"
#include "view/view_config.hpp"

namespace arkmesh::cli {
namespace {

using namespace std::chrono_literals;

struct ViewOptions {
  std::vector<std::string> what, sets;
  std::uint16_t port = view::ViewConfig().port;
  std::string address = view::ViewConfig().address;
  bool open = false;
  std::string federation, experiment, as;
  std::filesystem::path keys;
  gateway::FederationOptions connection;
};

struct BusOfLab {
  hal::BusConfig bus;
  std::string lab;
};

BusOfLab bus_of(const ViewOptions& options) {
  const std::string& what = options.what.front();
  if (what.find("://") != std::string::npos) return {.bus = {.url = what}};
  const hal::Section root = hal::Config::from_file(what, options.sets).root();
  return {.bus = root.section("bus").read<hal::BusConfig>(),
          .lab = root.section("lab").get("name", std::string(), {.required = true})};
}

// Until somebody stops it.
template <class Page>
void show(const Page& page, const ViewOptions& options, OperatorStop& stop, hal::EventLoop& loop) {
  if (page.port() != options.port)
    fmt::print(stderr, "TCP port {} is taken; the page is at {}\n", options.port, page.port());
  show_page(page.url(), {}, options.open);
  hal::LoopTime time(loop);
  while (!stop.stopped()) time.wait_for_anything(time.now() + 200ms);
}

void view_lab(const ViewOptions& options) {
  OperatorStop stop;
  const BusOfLab of = bus_of(options);
  view::ServerOptions server{.address = options.address, .port = options.port};
  if (!view::is_loopback(options.address)) server.identity = app::view_identity(of.lab, {options.address});
  hal::EventLoop loop;
  app::BusView page(loop, of.bus, of.lab, std::move(server));
  show(page, options, stop, loop);
}

void view_runs(const ViewOptions& options) {
  OperatorStop stop;
  if (!view::is_loopback(options.address))
    throw hal::ConfigError(
        "recorded runs are shown on this machine only; ssh -L 8800:127.0.0.1:8800 brings the page to another one");
  hal::EventLoop loop;
  const std::vector<std::filesystem::path> folders(options.what.begin(), options.what.end());
  recording::RecordedView page(loop, folders, {.address = options.address, .port = options.port});
  for (const std::string& note : page.notes()) fmt::print(stderr, "arkmesh: {}\n", note);
  show(page, options, stop, loop);
}

void view_federation(const ViewOptions& options) {
  OperatorStop stop;
  if (!options.what.empty())
    throw hal::ConfigError("--federation shows the labs of a federation; omit it to show a lab's file");
  if (!view::is_loopback(options.address))
    throw hal::ConfigError(
        "a federation is shown on this machine only; ssh -L 8800:127.0.0.1:8800 brings the page to another one");
  hal::EventLoop loop;
  const app::WatchedFederation federation{.servers = options.federation,
                                          .experiment = options.experiment,
                                          .keys = gateway::KeyFolder(options.keys),
                                          .name = options.as,
                                          .options = options.connection};
  app::FederationView page(loop, federation, {.address = options.address, .port = options.port});
  show(page, options, stop, loop);
}

void view_anything(const ViewOptions& options) {
  if (!options.federation.empty()) return view_federation(options);
  if (options.what.empty())
    throw hal::ConfigError(
        "say what to show: a lab's file, a run folder, or --federation nats://HOST --experiment NAME");
  const bool has_folder =
      std::ranges::any_of(options.what, [](const std::string& what) { return std::filesystem::is_directory(what); });
  if (has_folder) return view_runs(options);
  if (options.what.size() > 1)
    throw hal::ConfigError("one lab is shown at a time; two folders of recorded runs are compared");
  return view_lab(options);
}

}  // namespace

void add_view_command(CLI::App* command) {
  auto options = std::make_shared<ViewOptions>();
  command
      ->add_option(
          "what", options->what,
          "A lab's configuration file, or the URL of its public bus; or the folder of a recorded run or batch, or "
          "of two runs to compare")
      ->expected(0, 2);
  command->add_option("--port", options->port, "TCP port of the page; when it is taken, the next free one")
      ->capture_default_str();
  command
      ->add_option("--address", options->address,
                   "IP address to serve it on; beyond loopback over TLS, with the lab's key")
      ->capture_default_str();
  command->add_flag("--open", options->open, "Open the page in a browser");
  command->add_option("--set", options->sets, "Override a key of the file: --set bus.hear=[\"192.0.2.7\"]")
      ->allow_extra_args(false);
  const char* const watched = "Watch a federation";
  auto* const federation =
      command
          ->add_option("--federation", options->federation,
                       "Its NATS servers, as gateway.connect; arkmesh view publishes nothing there")
          ->group(watched);
  command->add_option("--experiment", options->experiment, "Name of its experiment: shared.experiment, or the scenario")
      ->group(watched)
      ->needs(federation);
  federation->needs("--experiment");
  command->add_option("--keys", options->keys, "Folder with the spectator's key and the trusted labs' certificates")
      ->group(watched)
      ->needs(federation);
  command->add_option("--as", options->as, "Name of the key in that folder, if it holds several")
      ->group(watched)
      ->needs(federation);
  command
      ->add_option("--server-ca", options->connection.server_ca,
                   "File of the CA certificates for its NATS servers, as gateway.server_ca")
      ->group(watched)
      ->needs(federation);
  command
      ->add_option("--credentials", options->connection.credentials,
                   "File of credentials for its NATS servers, as gateway.credentials")
      ->group(watched)
      ->needs(federation);
  command->footer(
      "Examples:\n  arkmesh view experiments/dhtf/shark.toml --open\n"
      "  arkmesh view runs/demo --open\n"
      "  arkmesh view runs/monday runs/tuesday\n"
      "  arkmesh view 'udpm://239.255.76.67:7667?ttl=0'\n"
      "  arkmesh view --federation nats://nats.example.org --experiment dhtf --open\n"
      "The lab prints the address of its own page, which also accepts commands.");
  command->callback([options] { view_anything(*options); });
}

}  // namespace arkmesh::cli
