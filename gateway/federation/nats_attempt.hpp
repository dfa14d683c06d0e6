// libnats' objects, owned, and how a connection to a server begins.
#pragma once

#include <nats/nats.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "gateway/federation/nats_connection.hpp"

namespace arkmesh::gateway::nats {

constexpr std::size_t read_bytes = 32 << 10;  // what libnats reads at once

template <class T, void (*destroy)(T*)>
struct Destroy {
  void operator()(T* object) const { destroy(object); }
};
using Connection = std::unique_ptr<natsConnection, Destroy<natsConnection, natsConnection_Destroy>>;
using Options = std::unique_ptr<natsOptions, Destroy<natsOptions, natsOptions_Destroy>>;
using Subscription = std::unique_ptr<natsSubscription, Destroy<natsSubscription, natsSubscription_Destroy>>;
using MessagePointer = std::unique_ptr<natsMsg, Destroy<natsMsg, natsMsg_Destroy>>;

// The socket as libnats wants it polled. It says so from within our calls only, once it is connected.
struct Polling {
  int socket = -1;
  std::function<void(bool wanted)> reading, writing;

  static natsStatus attach(void** user_data, void* loop, natsConnection*, natsSock socket) {
    *user_data = loop;
    static_cast<Polling*>(loop)->socket = socket;
    return NATS_OK;
  }
  static natsStatus read(void* user_data, bool wanted) {
    if (const auto& tell = static_cast<Polling*>(user_data)->reading) tell(wanted);
    return NATS_OK;
  }
  static natsStatus write(void* user_data, bool wanted) {
    if (const auto& tell = static_cast<Polling*>(user_data)->writing) tell(wanted);
    return NATS_OK;
  }
  static natsStatus detach(void*) { return NATS_OK; }
};

// What a thread that connects brings back.
struct Attempt {
  std::unique_ptr<Polling> polling = std::make_unique<Polling>();
  Connection connection;  // null: failed
  std::string error;
};

// What a server or libnats said of it, printable.
std::string words(natsStatus status, const char* more);

// Waits: for the name server, the server, its TLS.
void connect(const NatsSettings& settings, const NatsServer& server, Attempt& attempt);

}  // namespace arkmesh::gateway::nats
