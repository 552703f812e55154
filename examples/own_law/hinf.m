% An H-infinity law of one's own, from the model that `stillframe design SCENE --mat loop.mat` writes:
%   octave-cli hinf.m loop.mat law.mat
% hears the strain forces and remembers its commands. It is for frames whose floor and frame are measured along the legs and
% whose legs are alike, so that the modes come apart: six small problems, where SLICOT's solver is sound; on all legs at once
% its search for gamma ends far from the least (20 to 360 where modes give 2 to 3), some of its loops unstable.
pkg load control
1;

% Between the unit disk and the half plane, z = (1 + s) / (1 - s), which leaves every norm as it is.
function [A, B, C, D] = half_plane (A, B, C, D)
  X = inv (A + eye (rows (A)));
  D -= C * X * B;  A = X * (A - eye (rows (A)));  B = sqrt (2) * X * B;  C = sqrt (2) * C * X;
end
function [A, B, C, D] = unit_disk (A, B, C, D)
  X = inv (eye (rows (A)) - A);
  D += C * X * B;  A = X * (eye (rows (A)) + A);  B = sqrt (2) * X * B;  C = sqrt (2) * C * X;
end

% The least gamma to 2 %, with a closed loop that was looked at and a norm that was computed: the solver's own search
% (method "optimal") stops early on modes that nothing damps.
function [K, best] = least (P)
  low = 0.1;  best = Inf;  gamma = 100;  K = [];
  while (best > 1.02 * low && gamma < 1e6)
    sound = false;
    try
      [found, closed, norm_of_it] = hinfsyn (P, 1, 1, "method", "sub", "gmax", gamma);
      sound = all (real (pole (closed)) < 0) && norm_of_it <= 1.01 * gamma;
    end
    if (sound) best = gamma;  K = found; else low = gamma; end
    if (isinf (best)) gamma *= 4; else gamma = sqrt (low * best); end
  end
  if (isempty (K)) error ("no law was found"); end
end

given = argv ();
loop = load (given{1});
plant = loop.sampled_plant;  Ts = plant.Ts;
is = @(names, what) find (strncmp (names, what, numel (what)));
u = is (plant.input_names, "force:");
w = setdiff (1:numel (plant.input_names), u)';
sigma = is (plant.output_names, "sigma:");
applied = is (plant.output_names, "applied:");
y = setdiff (1:numel (plant.output_names), [sigma; applied; is(plant.output_names, "floor:")])';
m = numel (u);
if (numel (w) != m || numel (y) != m) error ("floor and frame have to be measured along the legs"); end

% States in units of their own size, as in lqg.m.
x = plant.B;  largest = max (abs (x), [], 2);
for k = 1:200
  x = plant.A * x;  largest = max (largest, max (abs (x), [], 2));
end
largest(largest == 0) = 1;
S = diag (largest);
A = S \ plant.A * S;  B = S \ plant.B;  C = plant.C * S;  n = rows (A);

% The mass that a leg moves: strain forces of a floor that is pushed for ever by 1 m/s^2.
M = -(C(sigma,:) - C(applied,:)) / (eye (n) - A) * B(:,w);
[V, masses] = eig ((M + M') / 2);
masses = diag (masses);

% What is asked for, from the inputs [floor; force that acts beside the command; noise of the sensor] to [frame; command]:
%   floor to frame      8 T less than gamma from 10 to 60 Hz
%   force to command    0.35 (S - 1/2) less than gamma above 180 Hz: the disk margin
% The other two, floor to command and force to frame, cannot be had small as well, and are balanced by `balance`.
low_pass = @(hz) tf (1, [1/(2*pi*hz), 1]);
floor_weight = ss (c2d (8 * 1.5/10 * tf ([1/(2*pi*1.5), 1], [1/(2*pi*10), 1]) * low_pass (60), Ts, "tustin"));
frame_weight = ss (c2d (low_pass (150), Ts, "tustin"));
force_weight = ss (c2d (tf ([1, 2*pi*180*0.025], [1, 2*pi*180]), Ts, "tustin"));
disk = 0.35;  noise = 0.3;  balance = 0.4;

law = struct ("A", [], "B", zeros (0, m), "C", zeros (m, 0), "D", zeros (m), "Ts", Ts);
for i = 1:m
  v = V(:,i);
  reach = x = [B(:,w) * v, B(:,u) * v];
  for k = 1:n
    x = A * x;  x ./= max (abs (x)) + realmin;  reach = [reach, x];
  end
  [Q, size_of, ~] = svd (reach ./ sqrt (sumsq (reach)), "econ");
  Q = Q(:, diag (size_of) > 1e-8);
  other = C([sigma; y],:) * Q - kron (eye (2), v * v') * C([sigma; y],:) * Q;
  if (norm (other) > 1e-6 * norm (C([sigma; y],:) * Q)) error ("the legs differ, and the modes do not come apart"); end
  a = balance / masses(i);
  mode_B = Q' * [a * B(:,w) * v, B(:,u) * v, zeros(n, 1), B(:,u) * v];
  mode_C = [v' * C(y,:) / a; zeros(1, n); v' * C(sigma,:)] * Q;
  mode_D = [v' * plant.D(y,w) * v, 0, 0, 0; 0, disk / 2, 0, disk; 0, 0, noise, 0];
  P = append (frame_weight, force_weight, ss (1, "tsam", Ts)) * ss (Q' * A * Q, mode_B, mode_C, mode_D, Ts) ...
      * append (floor_weight, force_weight, ss (eye (2), "tsam", Ts));
  [pA, pB, pC, pD] = ssdata (P);
  [pA, pB, pC, pD] = half_plane (pA, pB, pC, pD);
  [K, gamma] = least (ss (pA, pB, pC, pD));
  [kA, kB, kC, kD] = ssdata (K);
  [kA, kB, kC, kD] = unit_disk (kA, kB, kC, kD);
  printf ("a mode of %.0f kg: gamma %.2f, %d states\n", masses(i), gamma, rows (kA));
  law.A = blkdiag (law.A, kA);  law.B = [law.B; kB * v'];  law.C = [law.C, v * kC];  law.D += v * kD * v';
end
% A sensor feels its own actuator, and when a step of the command comes between two samples is a close thing:
% where it comes with the sample, a little less delay shows it a whole sample earlier, which no margin foresees. So the law does not hear sigma but the strain force, without
% the force that is applied, and adds what it knows to have been applied in this plant, its command of `lag` samples before.
lag = 0;  x = B(:,u);  seen = plant.D(applied,u);
while (norm (seen) < 0.5)
  lag++;  seen = C(applied,:) * x;  x = A * x;
end
Z = kron (diag (ones (1, lag - 1), -1), eye (m));
in = kron (eye (lag)(:,1), eye (m));  out = kron (eye (lag)(lag,:), eye (m));
law = struct ("A", [law.A, law.B * out; in * law.C, Z + in * law.D * out], "B", [law.B; in * law.D], ...
              "C", [law.C, law.D * out], "D", law.D, "Ts", Ts);
law.input_names = strrep (plant.output_names(sigma), "sigma:", "strain_force:");
law.output_names = plant.input_names(u);
save ("-v7", given{2}, "law");
