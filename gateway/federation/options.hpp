// What a lab's file says of federations, beside their servers.
#pragma once

#include <filesystem>

namespace arkmesh::gateway {

struct FederationOptions {
  std::filesystem::path server_ca, credentials;  // of the servers' certificates; of this lab for them
  bool encrypt = false;                          // what goes to many is for trusted labs only to read
};

}  // namespace arkmesh::gateway
