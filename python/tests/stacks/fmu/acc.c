/* A car follower of FMI 3.0, the intelligent driver model behind a lag of 0.2 s. Its state is global: a process can have one instance. */
#include <math.h>
#include <string.h>

#include "fmi3Functions.h"

enum { SPEED, SET_SPEED, GAP, LEAD_SPEED, TIME_GAP, ACCELERATION, NUMBERS };

static double number[NUMBERS];
static bool lead;

static void begin(void) {
    memset(number, 0, sizeof number);
    number[SET_SPEED] = 50.0;
    number[TIME_GAP] = 1.2;
    lead = false;
}

static void step(double length) {
    double speed = number[SPEED], closing = speed - number[LEAD_SPEED], wanted = 0.0;
    if (lead)
        wanted = 2.0 + fmax(0.0, speed * number[TIME_GAP] + speed * closing / (2.0 * sqrt(1.5 * 3.0)));
    double free = pow(speed / fmax(number[SET_SPEED] / 3.6, 0.1), 4.0), near = lead ? pow(wanted / fmax(number[GAP], 0.1), 2.0) : 0.0;
    double acceleration = fmax(1.5 * (1.0 - free - near), -8.0);
    number[ACCELERATION] += (acceleration - number[ACCELERATION]) * (1.0 - exp(-length / 0.2));
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
                                         fmi3Boolean early, const fmi3ValueReference required[], size_t count, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    begin();
    return strcmp(token, "falsify-acc") == 0 ? number : NULL;
}

void fmi3FreeInstance(fmi3Instance acc) {}
fmi3Status fmi3EnterInitializationMode(fmi3Instance acc, fmi3Boolean a, fmi3Float64 b, fmi3Float64 start, fmi3Boolean c, fmi3Float64 stop) { return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance acc) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance acc) { return fmi3OK; }

fmi3Status fmi3Reset(fmi3Instance acc) {
    begin();
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance acc, const fmi3ValueReference places[], size_t count, const fmi3Float64 values[], size_t numbers) {
    for (size_t i = 0; i < count; i++)
        number[places[i]] = values[i];
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance acc, const fmi3ValueReference places[], size_t count, fmi3Float64 values[], size_t numbers) {
    for (size_t i = 0; i < count; i++)
        values[i] = number[places[i]];
    return fmi3OK;
}

fmi3Status fmi3SetBoolean(fmi3Instance acc, const fmi3ValueReference places[], size_t count, const fmi3Boolean values[], size_t numbers) {
    lead = values[count - 1];
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance acc, fmi3Float64 time, fmi3Float64 length, fmi3Boolean whole, fmi3Boolean *event, fmi3Boolean *ends, fmi3Boolean *early,
                      fmi3Float64 *last) {
    step(length);
    *event = *ends = *early = false;
    *last = time + length;
    return fmi3OK;
}
