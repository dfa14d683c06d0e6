// `arkmesh reload` and the gateways that it asks, over local sockets that are no files: none is left of a gateway that
// was killed. Their names are random but for the gateway's file at their end, so that nobody can take one first, and
// the kernel tells each side whose the other one is.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace arkmesh::gateway {

// Where a gateway is asked to read its file again. Answers on the loop's thread.
class ReloadDoor {
 public:
  // `reload` reads the file and returns what it says: lines, or '!' and why the file is wrong. Only this user and root
  // are answered. Throws boost::system::system_error when the machine has no socket.
  ReloadDoor(boost::asio::io_context& io, const std::filesystem::path& file, std::function<std::string()> reload);
  ReloadDoor(const ReloadDoor&) = delete;
  ReloadDoor& operator=(const ReloadDoor&) = delete;

 private:
  void await_request();

  boost::asio::local::stream_protocol::acceptor acceptor_;
  boost::asio::steady_timer again_;
  std::function<std::string()> reload_;
};

// Makes the gateways that run with this file, of this user or root, read it again; root those of the file's owner, too.
// Returns what each says within 5 s, in lines, at most 64 KiB; nothing when none runs. Throws hal::ConfigError for a
// file that one of them does not take, std::runtime_error when nobody can be asked within 2 s.
std::vector<std::string> reload_gateways(const std::filesystem::path& file);

}  // namespace arkmesh::gateway
