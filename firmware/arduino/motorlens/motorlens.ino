// motorlens on an Arduino: plays programmes on a geared DC motor and prints what it does, line by line
// (docs/LINE_PROTOCOL.md). Flash it with the Arduino IDE, close the serial monitor, then on the computer:
//
//   motorlens capture --listen --port /dev/ttyACM0 --supply 12 --counts-per-rev 1320 --out logs
//
// Pins of an Uno or Nano. Encoder A and B must have interrupts of their own: 2 and 3 there, 0 and 1 on a Leonardo.
#if defined(__AVR__)
#include <avr/wdt.h>
#endif
#ifndef IRAM_ATTR
#define IRAM_ATTR // the ESP32 wants its interrupt routines in RAM; others do not know the word
#endif

const uint8_t ENCODER_A = 2, ENCODER_B = 3;
const uint8_t PWM_PIN = 9;        // the driver's PWM or enable input
const uint8_t IN1 = 7, IN2 = 8;   // its direction inputs; a driver with one direction input (PH) takes IN1
const uint8_t EMERGENCY = 4;      // a contact to ground that opens in an emergency; a jumper where there is none
const int8_t SUPPLY_PIN = -1;     // A0 behind a divider of the driver's supply; -1 where there is none
const uint32_t SUPPLY_FULL_MV = 55000; // the supply at which that pin reads 1023: 5 V behind 10 kOhm and 1 kOhm
const int16_t DUTY_FULL = 255;    // analogWrite's full scale
const int16_t LARGEST = 204;      // the largest duty that is ever applied
const uint32_t PERIOD_US = 4000;  // between two samples
const uint32_t SAMPLES = 2500;    // of each run: 10 s
const uint32_t LINK_MS = 1000;    // the motor stops when the computer is silent for so long
const int16_t STALL_DUTY = 100; const uint32_t STALL_MS = 500; // and when it stands for so long at this duty or more
const char *const NAMES[] = {"staircase", "triangle", "random-steps", "random-steps-repeat", "holdout-multisine"};
const uint8_t RUNS = 5;

volatile int32_t counted = 0;
volatile uint16_t lost = 0; // steps that went by unseen
char text[64];

// Every edge of A and B. A change of both at once is a step that went by unseen: its direction is unknown.
void IRAM_ATTR edge() {
  static uint8_t state = 0;
  static const int8_t STEP[16] = {0, -1, 1, 2, 1, 0, 2, -1, -1, 2, 0, 1, 2, 1, -1, 0};
  state = ((state << 2) | (digitalRead(ENCODER_A) << 1) | digitalRead(ENCODER_B)) & 15;
  int8_t step = STEP[state];
  if (step == 2) lost++; else counted += step;
}

int32_t count() {
  noInterrupts();
  int32_t now = counted;
  interrupts();
  return now;
}

void alive() {
#if defined(__AVR__)
  wdt_reset();
#endif
}

void release() { analogWrite(PWM_PIN, 0), digitalWrite(IN1, LOW), digitalWrite(IN2, LOW); }

void drive(int16_t duty) { // 0 is no voltage, not an open motor: a direction stays chosen
  digitalWrite(IN1, duty >= 0);
  digitalWrite(IN2, duty < 0);
  analogWrite(PWM_PIN, abs(duty));
}

// Prints a line with its check: the exclusive or of what stands before the star.
void say(const char *format, ...) {
  va_list values;
  va_start(values, format);
  vsnprintf(text, sizeof text, format, values);
  va_end(values);
  uint8_t check = 0;
  for (char *c = text; *c; c++) check ^= *c;
  Serial.print(text), Serial.print(check < 16 ? "*0" : "*"), Serial.println(check, HEX);
}

// The duty of sample k, a function of k alone: a sample that comes late changes nothing after it.
int16_t programme(uint8_t run, uint32_t k) {
  const float t = k * (PERIOD_US * 1e-6f);
  if (run == 0) { // up and down in steps of half a second, both ways, with rests
    static const int8_t LEVELS[20] = {2, 4, 6, 8, 10, 0, -2, -4, -6, -8, -10, 0, 10, -10, 5, -5, 3, -3, 8, 0};
    return LEVELS[(k / (SAMPLES / 20)) % 20] * (LARGEST / 10);
  }
  if (run == 1) { // 5 s a period: slow enough to show where the motor breaks away
    const float phase = fmodf(t / 5.0f + 0.25f, 1.0f);
    return LARGEST * (phase < 0.5f ? 4.0f * phase - 1.0f : 3.0f - 4.0f * phase);
  }
  if (run == 4) return LARGEST * (0.55f * sinf(2.51f * t) + 0.3f * sinf(8.17f * t) + 0.15f * sinf(23.9f * t));
  uint32_t h = (k / 50 + 1) * 0x9e3779b9UL; // another level every 0.2 s
  h = (h ^ (h >> 15)) * 0x2c1b3c6dUL;
  h ^= h >> 12;
  return (int16_t)(h % (2 * LARGEST + 1)) - LARGEST;
}

uint32_t supply_mv() {
  return SUPPLY_PIN < 0 ? 0 : analogRead(SUPPLY_PIN) * SUPPLY_FULL_MV / 1023;
}

// Plays one run; returns why it ended.
const char *play(uint8_t run) {
  uint32_t heard = millis(), moved = millis();
  const uint32_t begin = micros();
  int32_t stood = count();
  for (uint32_t next = 0; next < SAMPLES;) {
    alive();
    if (Serial.available()) {
      if (Serial.read() == 'o') return "stopped"; // "stop"; a late "start" has no o
      heard = millis();
    }
    if (digitalRead(EMERGENCY)) return "emergency";
    if (millis() - heard > LINK_MS) return "link loss";
    const uint32_t t = micros() - begin;
    if (t < next * PERIOD_US) continue;
    next = t / PERIOD_US + 1;
    const int32_t at = count();
    const int16_t duty = programme(run, next - 1);
    drive(duty);
    if (abs(duty) < STALL_DUTY || labs(at - stood) > 2) stood = at, moved = millis();
    if (millis() - moved > STALL_MS) return "stall";
    say("%lu,%d,%ld,%lu", (unsigned long)t, duty, (long)at, (unsigned long)supply_mv());
  }
  return "finished";
}

void setup() {
  pinMode(IN1, OUTPUT), pinMode(IN2, OUTPUT), pinMode(PWM_PIN, OUTPUT);
  release();
  pinMode(EMERGENCY, INPUT_PULLUP), pinMode(ENCODER_A, INPUT_PULLUP), pinMode(ENCODER_B, INPUT_PULLUP);
#if defined(__AVR__)
  TCCR1B = (TCCR1B & 0xf8) | 1; // PWM at 31 kHz on pins 9 and 10; 2 instead of 1 for 3.9 kHz (L298N)
  wdt_enable(WDTO_250MS);       // a board that hangs starts anew, with its pins off
#endif
  edge(), counted = 0, lost = 0;
  attachInterrupt(digitalPinToInterrupt(ENCODER_A), edge, CHANGE);
  attachInterrupt(digitalPinToInterrupt(ENCODER_B), edge, CHANGE);
  Serial.begin(250000);
  Serial.setTimeout(20);
}

void loop() {
  alive();
  if (!Serial.available()) return;
  text[Serial.readBytesUntil('\n', text, sizeof text - 1)] = 0; const uint8_t run = text[6] - '0';
  if (strncmp(text, "start ", 6) || run >= RUNS) return;
  for (int32_t stood = count() - 1, at, looks = 0; (at = count()) != stood; stood = at, delay(100), alive())
    if (++looks > 50) { while (Serial.read() >= 0) {} return; } // it turns: the computer asks again, if it still listens
  say("# programme: %s", NAMES[run]), say("# runs: %d", RUNS), say("# samples: %lu", (unsigned long)SAMPLES);
  say("# duty_full: %d", DUTY_FULL), say("t_us,duty,count,supply_mv");
  lost = 0;
  const char *why = play(run);
  release();
  say("# lost: %u", lost), say("# end: %s", why);
}
