"""What has to be said beside the figures."""

NOTES = (
    "The published column holds the paper's figures where it has any (saving, loss of speed, speed at the end, "
    "schedule, last gear). Those of the fuel model, of equal time, of the front and of the hills are page 5's of "
    "the specification: for the front a quick model, else goals.",
    "The paper's saving, 9.37 %, is fuel over the same way with nothing else regarded: a plan that is 3.18 km/h "
    "slower, against one driver, who is not published. Four drivers with frozen shift maps span 2.7 to 16 %: it "
    "says more about the driver than about the plan. In equal time and with equal kinetic energy at the end it is "
    "3.0 to 16 %; of the 14.1 % that the cheapest plan saves against the typical driver, being slower is 4 points. "
    "Against eco and late the cheapest plan is not 3.18 km/h slower: then it is the one that is driven.",
    "saving_realised may pass 1: where the gear rises a planner counts the rotation that the engine loses as lost, "
    "the plant's closing clutches hand most of it on. In fuel, drives and plans agree within 0.4 %. The driver is "
    "late by 0.1 s over the first metres, where the plan has torque at once; the plan that is driven is that much "
    "faster.",
    "gear_only_saving keeps the driver's speeds and takes the best gear at each place, with shifts that take "
    "neither time nor fuel; so it may pass the saving of the plan, which pays for them. The saving is one of gears: "
    "speed alone has next to nothing to give where time is kept.",
    "Cost of shifts: against the typical driver 10.7 % are left where a shift takes 0.05 s in neutral, 9.9 % at 0.2 "
    "s, 8.9 % at 0.5 s, the planner knowing of it. saving_realised falls below 0.95 in the last: the planner's 0.1 "
    "s for the ramps of the torque is then too little. Late drivers: 11 to 18 % by the choice of throttle and "
    "lines; 16 % is no finding.",
    "Ours shifts early as the paper's, but goes on to 5th at 70 m (65 m in equal time with the typical driver), "
    "where the paper stays in 4th until the end of the acceleration. That both end in 5th is the lowest engine "
    "speed: in 6th 49.8 km/h is 1188 rpm, below 1200; the economical speed is where 6th begins, at 50.4 km/h.",
    "Forward Euler in speed, as printed, adds (a ds / v)^2 to v^2 in each step, so that kinetic energy comes from "
    "nothing. At 2 m/s^2 from 5 km/h steps of 5 m are 12 km/h too fast after 10 m. A programme on that takes it as "
    "a gift: with steps of 5 m it is at 49.8 km/h after the first one, and promises 7.2 g, where the work at the "
    "wheels takes 12.3 g at the engine's best efficiency; with steps of 2 m it still undercuts that. The paper "
    "prints no step.",
    "On uniform speeds finer steps do not help: with exact steps the least fuel rises from 13.4 g at 2 m to 13.9 g "
    "at 0.5 m, since the smallest acceleration above none is v dv / ds, at 49.8 km/h 1.5 m/s^2. On steps uniform in "
    "v^2 that are refined together grid_gap is 0.01 %.",
    "The paper's schedule is of a 110 kW engine on the fuel of a car with a 2.0 L engine whose power is lost; ours "
    "has 112 kW. A full load that is 10 % higher on the same fuel moves upshifts by less than 0.5 km/h in the "
    "median, by up to 7 km/h below 80 % throttle, and beyond any sense above, where the torque leaves the fuel map. "
    "44 % of our points are no crossings: the higher gear is better as soon as 1200 rpm allow it.",
    "Three sigma of a bin that holds the row itself cannot fire in bins of 10 rows or fewer. Nor does it drop the "
    "0.26 % of a normal spread: on the measured cycles 1.3 %, of which one row is the meter's spike and the others "
    "are short rises.",
    "Hills are beyond the paper. A plan saves 3.4 % against a driver who holds the set speed with a shift map and "
    "wanders by some km/h, 1.9 of it by gears. Against a set speed that is held exactly, never passed and in the "
    "best gears, on half that road, it saves 0.4 % at a grade of 1.5 %, 1.4 % at 2 %, 3.7 % at 2.5 %, 6.9 % at 3.5 "
    "%, nothing on the flat. That is within a point what brakes and overrun no longer take on descents: at 2 % it "
    "is nearly all overrun, at 3.5 % nearly all braking. The rest is gears.",
)
