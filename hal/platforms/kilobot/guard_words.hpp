// What a program and its guard say to each other, each a packet of its own: the first byte is the word.
#pragma once

#include <sys/socket.h>
#include <sys/uio.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace arkmesh::hal::kilobot {

namespace guard_word {
// Of the program. A state: the word wanted, whether all stand, whether it has ended. `line` carries the descriptor.
inline constexpr std::uint8_t state = 's', lives = 'i', line = 'o', no_line = 'c';
// Of the guard: it is about to speak on the line; it has no copy of it any more, as an answer to no_line.
inline constexpr std::uint8_t takes_line = 't', leaves_line = 'l';
}  // namespace guard_word

// With a descriptor, unless that is -1. Never blocks. False: errno says why not.
inline bool send_word(int socket, const void* bytes, std::size_t n, int descriptor = -1) {
  iovec data{const_cast<void*>(bytes), n};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &data, message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = control, message.msg_controllen = sizeof control;
    cmsghdr* const carried = CMSG_FIRSTHDR(&message);
    carried->cmsg_level = SOL_SOCKET, carried->cmsg_type = SCM_RIGHTS, carried->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(carried), &descriptor, sizeof descriptor);
  }
  return ::sendmsg(socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(n);
}

// Returns what recvmsg() does. `descriptor`: what came with it, the caller's to close; unchanged when none came. Never
// blocks.
inline ssize_t receive_word(int socket, void* bytes, std::size_t n, int& descriptor) {
  iovec data{bytes, n};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &data, message.msg_iovlen = 1;
  message.msg_control = control, message.msg_controllen = sizeof control;
  const ssize_t got = ::recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  const cmsghdr* const carried = got > 0 ? CMSG_FIRSTHDR(&message) : nullptr;
  if (carried && carried->cmsg_type == SCM_RIGHTS) std::memcpy(&descriptor, CMSG_DATA(carried), sizeof descriptor);
  return got;
}

}  // namespace arkmesh::hal::kilobot
