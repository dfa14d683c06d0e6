// One place keeps where the caller goes on, since only one function runs at a time. It and the caller's registers lie
// outside of the other stack, so that nothing written there can change them.
#include "sim_ode/host/turns/context_switch.hpp"

// The code lies between 64 KB of traps: a return address on a damaged stack, of which only the low half is another,
// leads there.
#if defined(__x86_64__)
asm(R"(
.pushsection .text.arkmesh_stacks, "ax"
.macro arkmesh_save
  push %rbp
  push %rbx
  push %r12
  push %r13
  push %r14
  push %r15
.endm
.macro arkmesh_restore
  pop %r15
  pop %r14
  pop %r13
  pop %r12
  pop %rbx
  pop %rbp
  ret
.endm
.local arkmesh_caller
.comm arkmesh_caller, 8, 8
.fill 0x10000, 1, 0xCC
.globl arkmesh_call_on, arkmesh_leave, arkmesh_resume
.hidden arkmesh_call_on, arkmesh_leave, arkmesh_resume
arkmesh_call_on:
  arkmesh_save
  mov %rsp, arkmesh_caller(%rip)
  mov %rcx, %rsp
  mov %rdi, %rax
  mov %rsi, %rdi
  mov %rdx, %rsi
  call *%rax
arkmesh_back:
  mov arkmesh_caller(%rip), %rsp
  arkmesh_restore
arkmesh_leave:
  arkmesh_save
  mov %rsp, (%rdi)
  jmp arkmesh_back
arkmesh_resume:
  arkmesh_save
  mov %rsp, arkmesh_caller(%rip)
  mov %rdi, %rsp
  arkmesh_restore
.fill 0x10000, 1, 0xCC
.popsection
)");
#elif defined(__aarch64__)
asm(R"(
.pushsection .text.arkmesh_stacks, "ax"
.macro arkmesh_save
  stp x29, x30, [sp, #-160]!
  stp x19, x20, [sp, #16]
  stp x21, x22, [sp, #32]
  stp x23, x24, [sp, #48]
  stp x25, x26, [sp, #64]
  stp x27, x28, [sp, #80]
  stp d8, d9, [sp, #96]
  stp d10, d11, [sp, #112]
  stp d12, d13, [sp, #128]
  stp d14, d15, [sp, #144]
  mov x9, sp
.endm
.macro arkmesh_restore
  ldp x19, x20, [sp, #16]
  ldp x21, x22, [sp, #32]
  ldp x23, x24, [sp, #48]
  ldp x25, x26, [sp, #64]
  ldp x27, x28, [sp, #80]
  ldp d8, d9, [sp, #96]
  ldp d10, d11, [sp, #112]
  ldp d12, d13, [sp, #128]
  ldp d14, d15, [sp, #144]
  ldp x29, x30, [sp], #160
  ret
.endm
.local arkmesh_caller
.comm arkmesh_caller, 8, 8
.fill 0x4000, 4, 0xD4200000
.globl arkmesh_call_on, arkmesh_leave, arkmesh_resume
.hidden arkmesh_call_on, arkmesh_leave, arkmesh_resume
arkmesh_call_on:
  arkmesh_save
  adrp x10, arkmesh_caller
  str x9, [x10, :lo12:arkmesh_caller]
  mov sp, x3
  mov x9, x0
  mov x0, x1
  mov x1, x2
  blr x9
arkmesh_back:
  adrp x10, arkmesh_caller
  ldr x9, [x10, :lo12:arkmesh_caller]
  mov sp, x9
  arkmesh_restore
arkmesh_leave:
  arkmesh_save
  str x9, [x0]
  b arkmesh_back
arkmesh_resume:
  arkmesh_save
  adrp x10, arkmesh_caller
  str x9, [x10, :lo12:arkmesh_caller]
  mov sp, x0
  arkmesh_restore
.fill 0x4000, 4, 0xD4200000
.popsection
)");
#else
#error "robots' programs need a switch of stacks for this processor"
#endif
