// Who is there, and who makes way for whom: whoever has shown the token gets in as long as one is there who has not.
// Decides and keeps the lists; ending connections is the server's. Single-threaded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>

namespace arkmesh::view {

class Connection;

class Seats {
 public:
  // `beside`: connections beside those of viewers, for the page's files.
  Seats(std::size_t viewers, std::size_t beside) : viewers_(viewers), beside_(beside) {}

  struct Verdict {
    bool admitted = true;
    Connection* leaves = nullptr;  // before the newcomer comes; null: nobody
  };
  // One more connection: of those that neither watch nor have shown the token the one that was quiet for longest
  // leaves. So nobody keeps others out by connections alone.
  Verdict for_connection() const;
  // One of them wants to watch. For who has shown the token the newest viewer leaves who has not.
  Verdict for_viewer(bool has_token) const;

  void add(Connection& connection);
  // It has said something.
  void heard(Connection& connection);
  void watch(Connection& connection);
  // True: it watched.
  bool remove(Connection& connection);
  const std::set<Connection*>& watching() const { return watching_; }

 private:
  struct Seat {
    std::uint64_t heard = 0, watches_since = 0;  // turns
  };
  std::size_t viewers_, beside_;
  std::uint64_t turn_ = 0;
  std::map<Connection*, Seat> seats_;
  std::set<Connection*> watching_;  // of these
};

}  // namespace arkmesh::view
