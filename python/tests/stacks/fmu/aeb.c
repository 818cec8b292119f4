/* An emergency brake of FMI 2.0: it brakes for what is ahead within a time to collision, and keeps braking until the car stands. `fault` breaks it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { SPEED, DISTANCE, CLOSING, LATERAL, TTC, DECELERATION, FAULT_TIME, BRAKE, REALS };
enum { CLASS, FAULT, STATE, INTEGERS };
enum { NONE, CAR, PEDESTRIAN };
enum { OFF, BRAKES };
enum { WELL, CRASHES, HANGS, IS_NAN, REFUSES };

typedef struct {
    double real[REALS];
    int integer[INTEGERS];
    int enabled;
} Aeb;

static void begin(Aeb *aeb) {
    memset(aeb, 0, sizeof *aeb);
    aeb->real[DISTANCE] = 200.0;
    aeb->real[TTC] = 1.4;
    aeb->real[DECELERATION] = 9.0;
    aeb->enabled = 1;
}

static void step(Aeb *aeb, double length) {
    double *real = aeb->real, speed = real[SPEED] / 3.6;
    int ahead = aeb->integer[CLASS] != NONE && fabs(real[LATERAL]) < 2.0 && real[DISTANCE] < real[TTC] * real[CLOSING];
    if (aeb->integer[STATE] == OFF && aeb->enabled && ahead && speed > 1.0) {
        printf("AEB: brakes at %.1f m\n", real[DISTANCE]);
        aeb->integer[STATE] = BRAKES;
    }
    if (aeb->integer[STATE] == BRAKES && speed < 0.05 && real[DISTANCE] > 3.0)
        aeb->integer[STATE] = OFF;
    double wanted = aeb->integer[STATE] == BRAKES ? real[DECELERATION] : 0.0;
    /* A brake builds up in 0.1 s. */
    real[BRAKE] += (wanted - real[BRAKE]) * (1.0 - exp(-length / 0.1));
    if (real[BRAKE] < 0.01 && wanted == 0.0)
        real[BRAKE] = 0.0;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    Aeb *aeb = strcmp(guid, "falsify-aeb") == 0 ? malloc(sizeof *aeb) : NULL;
    if (aeb)
        begin(aeb);
    return aeb;
}

void fmi2FreeInstance(fmi2Component aeb) { free(aeb); }
fmi2Status fmi2SetupExperiment(fmi2Component aeb, fmi2Boolean a, fmi2Real b, fmi2Real start, fmi2Boolean c, fmi2Real stop) { return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component aeb) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component aeb) { return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component aeb) { return fmi2OK; }

/* As that of some others, it resets nothing. */
fmi2Status fmi2Reset(fmi2Component aeb) { return fmi2OK; }

fmi2Status fmi2SetReal(fmi2Component aeb, const fmi2ValueReference places[], size_t count, const fmi2Real values[]) {
    for (size_t i = 0; i < count; i++)
        ((Aeb *)aeb)->real[places[i]] = values[i];
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component aeb, const fmi2ValueReference places[], size_t count, fmi2Real values[]) {
    for (size_t i = 0; i < count; i++)
        values[i] = ((Aeb *)aeb)->real[places[i]];
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component aeb, const fmi2ValueReference places[], size_t count, const fmi2Integer values[]) {
    for (size_t i = 0; i < count; i++)
        ((Aeb *)aeb)->integer[places[i]] = values[i];
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component aeb, const fmi2ValueReference places[], size_t count, fmi2Integer values[]) {
    for (size_t i = 0; i < count; i++)
        values[i] = ((Aeb *)aeb)->integer[places[i]];
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component aeb, const fmi2ValueReference places[], size_t count, const fmi2Boolean values[]) {
    ((Aeb *)aeb)->enabled = values[count - 1];
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component aeb, const fmi2ValueReference places[], size_t count, fmi2Boolean values[]) {
    values[count - 1] = ((Aeb *)aeb)->enabled;
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real length, fmi2Boolean whole) {
    Aeb *aeb = component;
    step(aeb, length);
    if (time < aeb->real[FAULT_TIME])
        return fmi2OK;
    switch (aeb->integer[FAULT]) {
    case CRASHES:
        abort();
    case HANGS:
        for (volatile int i = 0;; i++)
            ;
    case IS_NAN:
        aeb->real[BRAKE] = NAN;
        return fmi2OK;
    case REFUSES:
        return fmi2Error;
    default:
        return fmi2OK;
    }
}
