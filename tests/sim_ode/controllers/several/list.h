#ifndef LIST_H
#define LIST_H
extern volatile unsigned char heard;
void list_listen(void);
void list_add(int number);
int list_sum(void);
#endif
