/* The C library's own, strictly the standard's part of it, and what the robot's library has beyond that. */
#include_next <string.h>
#ifndef ARKMESH_STRING_H
#define ARKMESH_STRING_H
int ffs(int value);
int ffsl(long value);
void* memccpy(void* to, const void* from, int end, size_t size);
void* memmem(const void* in, size_t size, const void* what, size_t what_size);
void* memrchr(const void* in, int what, size_t size);
int strcasecmp(const char* a, const char* b);
int strncasecmp(const char* a, const char* b, size_t size);
char* strcasestr(const char* in, const char* what);
char* strchrnul(const char* in, int what);
char* strdup(const char* text);
size_t strlcat(char* to, const char* from, size_t room);
size_t strlcpy(char* to, const char* from, size_t room);
char* strlwr(char* text);
size_t strnlen(const char* text, size_t most);
char* strrev(char* text);
char* strsep(char** text, const char* separators);
char* strtok_r(char* text, const char* separators, char** rest);
char* strupr(char* text);
#endif
