"use strict";
// The planned trial in the browser: the events of count_video.physics, one set-up at a time.
// Positions are the ball's wall-side face and the cylinder's face less a ball diameter, in metres
// from the wall, so that contact is equality. Contacts are found by steps that cannot jump over one.
globalThis.planCore = (() => {
  const GRAVITY = 9.81;
  const STEP_TOLERANCE = 1e-14;
  const RESTING_FRACTION = 1e-9;
  const MOST_COLLISIONS = 5000;
  const RESOLVED_FRAMES = 2.5;

  // A damped pendulum about a rest place.
  function pendulum(thread, damping, rest) {
    const stiffness = GRAVITY / thread;
    return {
      rest, damping, natural: Math.sqrt(stiffness),
      omega: Math.sqrt(stiffness - damping * damping),
    };
  }

  // Displacement and velocity after tau; small displacements keep their digits.
  function advance(law, place, velocity, tau) {
    const q = place - law.rest;
    const half = 0.5 * law.omega * tau;
    const halfSine = Math.sin(half);
    const sine = 2 * halfSine * Math.cos(half);
    const fall = 2 * halfSine * halfSine;
    const cosine = 1 - fall;
    const loss = Math.expm1(-law.damping * tau);
    const shrink = 1 + loss;
    const push = (velocity + law.damping * q) / law.omega;
    const pull = (law.natural * law.natural * q + law.damping * velocity) / law.omega;
    return [
      q * (loss * cosine - fall) + shrink * push * sine,
      shrink * (velocity * cosine - pull * sine),
    ];
  }

  // The swing as a complex number C, q = Re(C exp(lambda t)), multiplied by lambda squared.
  function bend(law, place, velocity) {
    const q = place - law.rest;
    const c = [q, -(velocity + law.damping * q) / law.omega];
    const r = [law.damping * law.damping - law.omega * law.omega, -2 * law.damping * law.omega];
    return [c[0] * r[0] - c[1] * r[1], c[0] * r[1] + c[1] * r[0]];
  }

  // When the velocity next passes from positive to negative.
  function turning(law, place, velocity) {
    const pull = (law.natural * law.natural * (place - law.rest) + law.damping * velocity)
      / law.omega;
    if (velocity === 0 && pull === 0) return Infinity;
    const angle = Math.atan2(velocity, pull);
    return (angle > 0 ? angle : angle + 2 * Math.PI) / law.omega;
  }

  // First positive zero of gap + slope s - curvature s^2 / 2.
  function safeStep(gap, slope, curvature) {
    const root = Math.sqrt(slope * slope + 2 * curvature * gap);
    if (slope < 0) return 2 * gap / (root - slope);
    return curvature > 0 ? (slope + root) / curvature : Infinity;
  }

  // First zero of a positive function whose second derivative is at most the curvature.
  function firstZero(evaluate, start, curvature, window) {
    let tau = start;
    while (tau <= window) {
      const [value, slope] = evaluate(tau);
      if (value <= 0) return Math.max(start, slope < 0 ? tau - value / slope : tau);
      const step = safeStep(value, slope, curvature);
      tau += step;
      const within = STEP_TOLERANCE * tau;
      if (step <= within || curvature * step * step <= -slope * within) {
        return tau <= window ? tau : Infinity;
      }
    }
    return Infinity;
  }

  function wallContact(light, state, window) {
    const curvature = Math.hypot(...bend(light, state.ball, state.ballVelocity));
    return firstZero((tau) => {
      const [rise, velocity] = advance(light, state.ball, state.ballVelocity, tau);
      return [state.ball + rise, velocity];
    }, safeStep(state.ball, state.ballVelocity, curvature), curvature, window);
  }

  function bodiesContact(heavy, light, state, window) {
    const gap = state.heavy - state.ball;
    const upper = bend(heavy, state.heavy, state.heavyVelocity);
    const lower = bend(light, state.ball, state.ballVelocity);
    const apart = Math.hypot(...upper) + Math.hypot(...lower);
    const drift = Math.hypot(heavy.damping - light.damping, heavy.omega - light.omega)
      * window;
    const near = Math.hypot(upper[0] - lower[0], upper[1] - lower[1])
      + Math.hypot(...lower) * drift;
    const curvature = Math.min(apart, near);
    return firstZero((tau) => {
      const [rise, up] = advance(heavy, state.heavy, state.heavyVelocity, tau);
      const [climb, low] = advance(light, state.ball, state.ballVelocity, tau);
      return [gap + rise - climb, up - low];
    }, safeStep(gap, state.heavyVelocity - state.ballVelocity, curvature), curvature, window);
  }

  // Time of flight to the next contact before the cylinder turns; Infinity if there is none.
  function nextContact(heavy, light, state, turn) {
    // A cylinder at rest never turns; the ball comes back to it within a swing, or stays away.
    const window = turn === Infinity ? 1.01 * 2 * Math.PI / light.omega : turn;
    let wall = Infinity;
    let bodies = Infinity;
    if (state.heavy === state.ball) {  // bodies that touch now seldom meet next: theirs comes last
      wall = wallContact(light, state, window);
      bodies = bodiesContact(heavy, light, state, Math.min(window, wall));
    } else {
      bodies = bodiesContact(heavy, light, state, window);
      wall = wallContact(light, state, Math.min(window, bodies));
    }
    return wall < bodies ? [wall, "wall"] : [bodies, "bodies"];
  }

  // The burst of a set-up. `scatter`, if given, is called once a bounce and added to its restitution.
  // `endless` is true where bodies come to rest on each other: then the count is no count.
  function burst(setup, scatter) {
    const heavy = pendulum(setup.heavyThread, setup.damping, setup.gap);
    const light = pendulum(setup.lightThread, setup.damping, setup.gap);
    const slow = RESTING_FRACTION * setup.release * heavy.natural;
    let state = {
      time: 0, heavy: setup.gap + setup.release, heavyVelocity: 0,
      ball: setup.gap, ballVelocity: 0,
    };
    const states = [state];
    const collisions = [];
    for (;;) {
      const turn = turning(heavy, state.heavy, state.heavyVelocity);
      const [flight, kind] = nextContact(heavy, light, state, turn);
      if (flight === Infinity) {
        return { heavy, light, states, collisions, turn: state.time + turn, endless: false };
      }
      const [rise, heavyVelocity] = advance(heavy, state.heavy, state.heavyVelocity, flight);
      const [climb, ballVelocity] = advance(light, state.ball, state.ballVelocity, flight);
      const atWall = kind === "wall";
      const ball = atWall ? 0 : Math.max(0, state.ball + climb);
      const place = atWall ? Math.max(ball, state.heavy + rise) : ball;
      const approach = atWall ? -ballVelocity : ballVelocity - heavyVelocity;
      const mean = atWall ? setup.restitutionWall : setup.restitutionBodies;
      const bounce = Math.min(1, Math.max(0, mean + (scatter ? scatter() : 0)));
      const resting = approach <= slow || bounce * approach <= slow;
      if (resting || collisions.length >= MOST_COLLISIONS) {
        return { heavy, light, states, collisions, turn: Infinity, endless: true };
      }
      const push = (1 + bounce) * approach / (setup.ratio + 1);
      const before = { heavyVelocity, ballVelocity };
      state = {
        time: state.time + flight, heavy: place, ball,
        heavyVelocity: heavyVelocity + (atWall ? 0 : push),
        ballVelocity: atWall ? -bounce * ballVelocity : ballVelocity - setup.ratio * push,
      };
      states.push(state);
      collisions.push({ kind, time: state.time, place: ball, approach, before, after: state });
    }
  }

  // Exact count of free bodies without losses: ceil(pi / theta) - 1.
  function theory(ratio) {
    const quotient = Math.PI / Math.atan(Math.sqrt(1 / ratio));
    const whole = Math.round(quotient);
    return Math.abs(quotient - whole) < 1e-12 * whole ? whole - 1 : Math.ceil(quotient) - 1;
  }

  // What the page says of a burst.
  function facts(setup) {
    const found = burst(setup);
    const times = found.collisions.map((c) => c.time);
    const intervals = times.slice(1).map((time, k) => time - times[k]);
    const shortest = Math.min(Infinity, ...intervals);
    return {
      ...found, intervals, shortest, count: times.length,
      bodies: found.collisions.filter((c) => c.kind === "bodies").length,
      theory: theory(setup.ratio),
      needed: shortest === Infinity ? 10 : 10 * Math.ceil(RESOLVED_FRAMES / shortest / 10),
    };
  }

  // Place and velocity of both at a time of the burst, from the state before it.
  function at(found, time) {
    const state = found.states.findLast((one) => one.time <= time) ?? found.states[0];
    const tau = Math.max(0, time - state.time);
    return {
      heavy: state.heavy + advance(found.heavy, state.heavy, state.heavyVelocity, tau)[0],
      ball: state.ball + advance(found.light, state.ball, state.ballVelocity, tau)[0],
    };
  }

  return { burst, facts, theory, at, RESOLVED_FRAMES };
})();
