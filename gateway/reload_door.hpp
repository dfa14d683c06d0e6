// `arkmesh reload` and the gateways that it asks, over local sockets that are no files: none is left of a gateway that
// was killed. They bear the name of the gateway's file, and the kernel tells each side whose the other one is.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace arkmesh::gateway {

// Where a gateway is asked to read its file again. Answers on the loop's thread.
class ReloadDoor {
 public:
  // `reload` reads the file and returns what it says: lines, or '!' and why the file is wrong.
  ReloadDoor(boost::asio::io_context& io, const std::filesystem::path& file, std::function<std::string()> reload);
  ReloadDoor(const ReloadDoor&) = delete;
  ReloadDoor& operator=(const ReloadDoor&) = delete;

  // Eight gateways of one file, which differ by --set, can be asked; a ninth one has no door.
  bool is_open() const { return acceptor_.is_open(); }

 private:
  void await_request();

  boost::asio::local::stream_protocol::acceptor acceptor_;
  std::function<std::string()> reload_;
};

// Makes the gateways that run with this file, of this user, read it again. Returns what each says, in lines; nothing
// when none runs. Throws hal::ConfigError for a file that one of them does not take.
std::vector<std::string> reload_gateways(const std::filesystem::path& file);

}  // namespace arkmesh::gateway
