// The way to the original: one connection at a time, made again after a loss, for as long as the link lives. Never
// closed first.
#pragma once

#include <string>
#include <string_view>

#include "hal/time/wall_time.hpp"

namespace arkmesh::mark {

class Link {
 public:
  // Told from within serve() and send().
  class Events {
   public:
    virtual void came() = 0;                         // the original is there, anew
    virtual void heard(std::string_view bytes) = 0;  // as they came: cut and merged
    virtual void gone(const std::string& why) = 0;   // "it closed its connection"

   protected:
    ~Events() = default;
  };
  virtual ~Link() = default;
  // Once. `events` outlives the link. Throws std::runtime_error with one sentence, of a port that is taken.
  virtual void start(Events& events) = 0;
  // From now on the original may come, or is connected to. Once, after start(). Throws as start().
  virtual void open() = 0;
  // Hands over what has come. Quick; to be called often, at next_service() at the latest.
  virtual void serve() = 0;
  virtual hal::TimePoint next_service() const = 0;
  virtual bool up() const = 0;
  // All that was sent has reached the other machine.
  virtual bool settled() const = 0;
  // One message, delimiter included, as one write. Only while up() and settled().
  virtual void send(std::string_view message) = 0;
  // Where the original comes or is: "127.0.0.1:7001"; and why it is not there, as the end of a sentence, or nothing.
  virtual std::string place() const = 0;
  virtual std::string error() const = 0;
};

}  // namespace arkmesh::mark
