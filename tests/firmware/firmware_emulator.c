/* One Kilobot's processor in simavr, for tests/firmware/firmware_table: light comes in, motors and LED are looked at. Knows
   nothing of messages. Called with PROGRAM.bin, BOOT.bin or -, and the addresses of the program's two counters.

   Lines of the standard input:

   run CYCLES               time passes

   pulses CYCLE CYCLE ...   light at these moments, from when interrupts are on

   eeprom ADDRESS VALUE     before the first `run`

   page ADDRESS             says 128 bytes of the flash

   look                     says MOTOR MOTOR COLOUR ASKED SETUPS */
#include <simavr/avr_acomp.h>
#include <simavr/avr_adc.h>
#include <simavr/avr_eeprom.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_io.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { hz = 8000000, boot_at = 0x7000, last_vector = 25 * 4 };
/* Addresses in the ATmega328P's data space. */
enum { DDRB = 0x24, DDRC = 0x27, DDRD = 0x2A, MCUCR = 0x55, OCR2A = 0xB3, OCR2B = 0xB4 };

static avr_t* avr;
static FILE* answers;
static uint8_t program[0x8000], boot[0x1000];
static uint32_t boot_bytes;

static uint32_t load(const char* name, uint8_t* to, size_t size) {
  FILE* file = fopen(name, "rb");
  if (!file) {
    fprintf(stderr, "firmware_emulator: %s cannot be read\n", name);
    exit(2);
  }
  size = fread(to, 1, size, file);
  fclose(file);
  return (uint32_t)size;
}

static void sleep_without_waiting(avr_t* robot, avr_cycle_count_t cycles) {
  (void)robot, (void)cycles;
}

static void run_to(avr_cycle_count_t cycle) {
  while (avr->cycle < cycle) {
    const int state = avr_run(avr);
    /* kilolib calls the boot loader with its address in bytes where the processor takes words, and gets there: the
       processor ignores the top bits, and walks through the empty flash below the boot loader */
    avr->pc &= avr->flashend;
    if (state == cpu_Done || state == cpu_Crashed) {
      fprintf(stderr, "firmware_emulator: the program crashed at %04x\n", (unsigned)avr->pc);
      exit(1);
    }
    /* simavr knows nothing of the boot loader's own interrupt vectors, which MCUCR's bit IVSEL chooses */
    if ((avr->data[MCUCR] & 2) && avr->pc > 0 && avr->pc <= last_vector && avr->pc % 4 == 0) avr->pc += boot_at;
  }
}

static int duty(int direction, int bit, int compare) {
  return avr->data[direction] >> bit & 1 ? avr->data[compare] : 0;
}

/* One bit each for red, green and blue. */
static int colour(void) {
  const int d = avr->data[DDRD], c = avr->data[DDRC];
  return (d >> 4 & 3 ? 1 : 0) | (c >> 2 & 3 ? 2 : 0) | (c >> 4 & 3 ? 4 : 0);
}

/* The colour of most of the next 0.25 s. */
static int steady_colour(void) {
  int count[8] = {0}, best = 0, i;
  for (i = 0; i < 250; i++) {
    run_to(avr->cycle + hz / 1000);
    count[colour()]++;
  }
  for (i = 1; i < 8; i++)
    if (count[i] > count[best]) best = i;
  return best;
}

static void pulses(const char* list) {
  avr_irq_t* const light = avr_io_getirq(avr, AVR_IOCTL_ACOMP_GETIRQ, ACOMP_IRQ_AIN0);
  avr_cycle_count_t from;
  char* rest;
  for (from = avr->cycle; !avr->sreg[S_I]; run_to(avr->cycle + 1))
    if (avr->cycle > from + 10 * hz) {
      fprintf(stderr, "firmware_emulator: the robot hears nothing: its interrupts were off for 10 s\n");
      exit(1);
    }
  from = avr->cycle;
  for (;;) {
    const unsigned long at = strtoul(list, &rest, 10);
    if (rest == list) return;
    list = rest;
    run_to(from + at);
    avr_raise_irq(light, 3000);
    run_to(from + at + 9);
    avr_raise_irq(light, 0);
  }
}

int main(int count, char** words) {
  static char line[4096];
  unsigned asked, setups, address, value;
  unsigned long cycles;
  if (count != 5) return 2;
  asked = (unsigned)strtoul(words[3], 0, 0) & 0xFFFF;
  setups = (unsigned)strtoul(words[4], 0, 0) & 0xFFFF;
  /* simavr talks on the standard output: the answers get a stream of their own */
  answers = fdopen(dup(1), "w");
  if (!answers || !freopen("/dev/null", "w", stdout)) return 2;
  avr = avr_make_mcu_by_name("atmega328p");
  if (!avr) return 2;
  avr_init(avr);
  avr->frequency = hz;
  avr->vcc = avr->avcc = avr->aref = 3300;
  avr->sleep = sleep_without_waiting;
  avr_loadcode(avr, program, load(words[1], program, sizeof program), 0);
  if (strcmp(words[2], "-") != 0) {
    boot_bytes = load(words[2], boot, sizeof boot);
    avr_loadcode(avr, boot, boot_bytes, boot_at);
  }
  avr->codeend = avr->flashend;
  avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ACOMP_GETIRQ, ACOMP_IRQ_AIN1), 1500);
  avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC6), 2826); /* a full battery: 876 */

  while (fgets(line, sizeof line, stdin)) {
    if (sscanf(line, "run %lu", &cycles) == 1) run_to(avr->cycle + cycles);
    if (strncmp(line, "pulses ", 7) == 0) pulses(line + 7);
    if (sscanf(line, "eeprom %u %u", &address, &value) == 2) {
      uint8_t byte = (uint8_t)value;
      avr_eeprom_desc_t change = {.ee = &byte, .offset = (uint16_t)address, .size = 1};
      avr_ioctl(avr, AVR_IOCTL_EEPROM_SET, &change);
    }
    if (sscanf(line, "page %u", &address) == 1) {
      unsigned i;
      for (i = 0; i < 128; i++) fprintf(answers, "%u ", avr->flash[address + i]);
      fprintf(answers, "\n");
      fflush(answers);
    }
    if (strncmp(line, "look", 4) == 0) {
      const int left = duty(DDRB, 3, OCR2A), right = duty(DDRD, 3, OCR2B), light = steady_colour();
      const uint8_t before = avr->data[asked];
      run_to(avr->cycle + 17 * 256 * 1024);
      fprintf(answers, "%d %d %d %d %d\n", left, right, light, (uint8_t)(avr->data[asked] - before), avr->data[setups]);
      fflush(answers);
    }
  }
  return 0;
}
