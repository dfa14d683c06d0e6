#include "gateway/federation/nats_attempt.hpp"

#include <fmt/format.h>

#include <chrono>

#include "hal/label.hpp"

namespace arkmesh::gateway::nats {
namespace {

constexpr std::chrono::milliseconds connect_time{2000};
constexpr std::size_t longest_error = 200;

}  // namespace

std::string words(natsStatus status, const char* more) {
  std::string text = more && *more ? more : natsStatus_GetText(status);
  return hal::printable(text, longest_error);
}

void connect(const NatsSettings& settings, const NatsServer& server, Attempt& attempt) {
  natsOptions* made = nullptr;
  if (natsOptions_Create(&made) != NATS_OK) {
    attempt.error = "libnats cannot start";
    return;
  }
  const Options options(made);
  const std::string url = fmt::format("{}://{}", settings.servers.tls ? "tls" : "nats", to_text(server.host));
  natsStatus status = natsOptions_SetURL(made, url.c_str());
  const auto then = [&status](natsStatus next) {
    if (status == NATS_OK) status = next;
  };
  then(natsOptions_SetName(made, settings.name.c_str()));
  then(natsOptions_SetTimeout(made, connect_time.count()));
  then(natsOptions_SetIOBufSize(made, read_bytes));
  then(natsOptions_SetAllowReconnect(made, false));  // the next server is ours to choose
  then(natsOptions_SetIgnoreDiscoveredServers(made, true));
  then(natsOptions_SetPingInterval(made, 0));  // would close the connection from a thread
  then(natsOptions_SetSendAsap(made, true));
  then(natsOptions_SetEventLoop(made, attempt.polling.get(), Polling::attach, Polling::read, Polling::write,
                                Polling::detach));
  if (!server.user.empty()) then(natsOptions_SetUserInfo(made, server.user.c_str(), server.password.c_str()));
  if (!settings.credentials.empty())
    then(natsOptions_SetUserCredentialsFromFiles(made, settings.credentials.c_str(), nullptr));
  if (settings.servers.tls) {
    then(natsOptions_SetSecure(made, true));
    if (!settings.server_ca.empty()) then(natsOptions_LoadCATrustedCertificates(made, settings.server_ca.c_str()));
    then(natsOptions_SetExpectedHostname(made, server.host.name.c_str()));
  }
  natsConnection* connection = nullptr;
  if (status == NATS_OK) status = natsConnection_Connect(&connection, made);
  if (status == NATS_OK)
    attempt.connection.reset(connection);
  else
    attempt.error = words(status, nats_GetLastError(nullptr));
}

}  // namespace arkmesh::gateway::nats
