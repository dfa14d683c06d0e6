// `arkmesh keys`: who this lab is to others, and which labs its gateway lets in.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "cli/commands.hpp"
#include "gateway/links/key_folder.hpp"

namespace arkmesh::cli {
namespace {

using gateway::Certificate;
using gateway::KeyFolder;

struct KeysOptions {
  std::filesystem::path folder;  // empty: the default
  std::string what;              // a lab or a file
  bool replace = false, new_key = false;
};

std::string date(std::chrono::system_clock::time_point when) {
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(when));
}

void print_fingerprint(const Certificate& certificate) {
  fmt::print("fingerprint  {}  (25 digits, 83 bits)\n", gateway::fingerprint(certificate.pin));
}

void init(const KeysOptions& options, const KeyFolder& keys) {
  const Certificate made = keys.init(options.what);
  fmt::print("lab {} has a key, and a certificate until {}\n", made.lab, date(made.until));
  fmt::print("certificate  {}  (give this file to the other labs, but never the key beside it)\n",
             keys.certificate_file(made.lab).string());
  print_fingerprint(made);
  fmt::print("Read the fingerprint out to the other labs, for example by phone, when they trust the certificate.\n");
}

void trust(const KeysOptions& options, const KeyFolder& keys) {
  const Certificate trusted = keys.trust(options.what, options.replace);
  fmt::print("lab {} is trusted; its certificate is valid until {}\n", trusted.lab, date(trusted.until));
  print_fingerprint(trusted);
  fmt::print("Compare it with what lab {} reads out; if it differs: arkmesh keys revoke {}\n", trusted.lab,
             trusted.lab);
}

void revoke(const KeysOptions& options, const KeyFolder& keys) {
  const Certificate revoked = keys.revoke(options.what);
  fmt::print("lab {} is no longer trusted; running gateways close their connection to it within a second\n",
             revoked.lab);
}

void renew(const KeysOptions& options, const KeyFolder& keys) {
  const Certificate renewed = keys.renew(options.what, options.new_key);
  fmt::print("the certificate of lab {} is valid until {}\n", renewed.lab, date(renewed.until));
  print_fingerprint(renewed);
  if (options.new_key)
    fmt::print("Its key is new: the other labs must run arkmesh keys trust {}.crt --replace\n", renewed.lab);
  else
    fmt::print("Its key is the same, so the other labs need not do anything.\n");
}

void list(const KeysOptions&, const KeyFolder& keys) {
  const KeyFolder::Listing listing = keys.list();
  const auto print = [](const char* what, const std::vector<Certificate>& certificates) {
    for (const Certificate& each : certificates)
      fmt::print("{:<8} {:<15} {}  until {}\n", what, each.lab, gateway::fingerprint(each.pin), date(each.until));
  };
  print("own", listing.own);
  print("trusted", listing.trusted);
  print("revoked", listing.revoked);
  if (listing.own.empty() && listing.trusted.empty() && listing.revoked.empty())
    fmt::print("no keys in {}; create a lab's own with: arkmesh keys init LAB\n", keys.path().string());
  for (const std::string& sentence : listing.damaged) fmt::print(stderr, "arkmesh: {}\n", sentence);
}

}  // namespace

void add_keys_command(CLI::App* command) {
  command->require_subcommand(1);
  const auto options = std::make_shared<KeysOptions>();
  const auto add = [&](const char* name, const char* purpose, void (*act)(const KeysOptions&, const KeyFolder&)) {
    CLI::App* each = command->add_subcommand(name, purpose);
    each->add_option("--keys", options->folder, "Folder of keys, as gateway.keys (default: ~/.config/arkmesh/keys)");
    each->callback([options, act] { act(*options, KeyFolder(options->folder)); });
    return each;
  };
  add("init", "Create a lab's private key and certificate", init)
      ->add_option("lab", options->what, "The lab's name")
      ->required();
  CLI::App* const trusting = add("trust", "Trust the lab that has this certificate", trust);
  trusting->add_option("file", options->what, "The file that the lab gave you")->required();
  trusting->add_flag("--replace", options->replace, "Replace another certificate of the same lab, or a revoked one");
  add("list", "List own, trusted and revoked certificates with their fingerprints", list);
  add("revoke", "Stop trusting a lab", revoke)->add_option("lab", options->what, "The lab's name")->required();
  CLI::App* const renewing = add("renew", "Extend a lab's own certificate by ten years", renew);
  renewing->add_option("lab", options->what, "The lab's name")->required();
  renewing->add_flag("--new-key", options->new_key,
                     "Also replace the key, for example after a theft; the other labs must trust it again");
  command->footer(
      "Example, at lab shark, which has received roark.crt by mail:\n  arkmesh keys init shark\n  arkmesh keys trust "
      "roark.crt\n"
      "Exit codes: 0 done, 1 cannot write, 2 wrong command line, file or name.");
}

}  // namespace arkmesh::cli
