/* Lets libserialport open a pseudo-terminal: those have no modem lines, which it wants to read and set. Linked before the C library or
   preloaded; everything else goes through. Under a sanitizer preload its library first. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdarg.h>
#include <sys/ioctl.h>
#include <unistd.h>

int ioctl(int fd, unsigned long request, ...) {
  static int (*next)(int, unsigned long, ...);
  va_list arguments;
  va_start(arguments, request);
  void *argument = va_arg(arguments, void *);
  va_end(arguments);
  if (!next) next = (int (*)(int, unsigned long, ...))dlsym(RTLD_NEXT, "ioctl");
  int result = next(fd, request, argument);
  if (result != 0 && (errno == ENOTTY || errno == EINVAL) && isatty(fd)) {
    if (request == TIOCMGET) *(int *)argument = 0;
    if (request == TIOCMGET || request == TIOCMSET || request == TIOCMBIS || request == TIOCMBIC) return 0;
  }
  return result;
}
