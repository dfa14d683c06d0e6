.global message_sent
message_sent:
  ret
