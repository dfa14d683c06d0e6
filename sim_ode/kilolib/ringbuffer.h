/* Ring buffers as macros, for programs that use them by name and for message_buffered.h. The newest element overwrites
   the oldest when a buffer is full. */
#ifndef __RINGBUFFER_H__
#define __RINGBUFFER_H__

#ifndef RB_counter
#define RB_counter unsigned int
#endif

#define RB_create(NAME, T, SIZE)                   \
  struct {                                         \
    RB_counter head, count; /* oldest, how many */ \
    T elems[SIZE];                                 \
  } NAME;                                          \
  enum { NAME##_rbsize = SIZE }

#define RB_init(o) \
  { o.head = o.count = 0; }
#define RB_clear(o) RB_init(o)
#define RB_capacity(o) o##_rbsize
#define RB_size(o) o.count
#define RB_empty(o) (o.count == 0)
#define RB_full(o) (o.count == o##_rbsize)
#define RB_front(o) o.elems[o.head]
#define RB_back(o) o.elems[(o.head + o.count) % o##_rbsize]
#define RB_popfront(o)                  \
  {                                     \
    o.head = (o.head + 1) % o##_rbsize; \
    o.count--;                          \
  }
#define RB_pushback(o)                    \
  {                                       \
    if (RB_full(o))                       \
      o.head = (o.head + 1) % o##_rbsize; \
    else                                  \
      o.count++;                          \
  }

#endif
