% Octave's control package on the numbers of every case: called as octave-cli control_package.m
% FOLDER, reads FOLDER/*.given and writes FOLDER/*.answer. Ends with 77 without the package.
% Nothing of the program's own results is read: loops are built here from the plant, the gains and
% the settings, by append, mconnect, feedback, lft, series and c2d.
try
  pkg load control
catch
  exit(77);
end

% -- Writing ---------------------------------------------------------------------------------------

function put(file, name, values)
  fprintf(file, "%s %d %d\n", name, rows(values), columns(values));
  fprintf(file, "%.17g %.17g\n", [real(values(:))'; imag(values(:))']);
end

% Frequency response, entries of one frequency in a column.
function H = response(sys, omega)
  [p, m] = size(sys);
  H = reshape(freqresp(sys, omega(:)'), p * m, numel(omega));
end

% -- Laws ------------------------------------------------------------------------------------------

% P(s) = (K_P s + K_I) / (s + omega_l) * s / (s + omega_h).
function P = proportional_integral(g)
  m = rows(g.K_P);
  I = eye(m);
  corners = sort([g.leak, g.high_pass], "descend");
  P = ss(-corners(1) * I, I, g.K_I - corners(1) * g.K_P, g.K_P);
  if corners(2) > 0
    P = ss(-corners(2) * I, I, -corners(2) * I, I) * P;
  end
end

% (1 + tau s) corner / (s + corner).
function sys = low_pass(corner, tau, m)
  I = eye(m);
  sys = ss(-corner * I, corner * I, (1 - tau * corner) * I, tau * corner * I);
end

function F = rolled_off(F, g)
  if g.roll_off > 0
    F = low_pass(g.roll_off, g.tau, rows(g.K_P)) * F;
  end
end

% The law on the strain force: -(I + P)^-1 P, then the roll-off.
function F = strain_law(g)
  F = rolled_off(-feedback(proportional_integral(g), eye(rows(g.K_P))), g);
end

% u = C sigma: C = -P, or with a roll-off u = F (sigma - u).
function C = stress_law(g)
  if g.roll_off > 0
    C = feedback(strain_law(g), eye(rows(g.K_P)));
  else
    C = -proportional_integral(g);
  end
end

% -- Continuous loop -------------------------------------------------------------------------------

% The plant from (w, v, u) to (y, sigma + v), of the first n states.
function G = generalised_plant(g, n)
  m = columns(g.B_u);
  n_y = rows(g.C_y);
  p = columns(g.B_w);
  G = ss(g.A(1:n, 1:n), [g.B_w(1:n, :), zeros(n, m), g.B_u(1:n, :)], ...
         [g.C_y(:, 1:n); g.C_sigma(:, 1:n)], ...
         [g.D_yw, zeros(n_y, m), g.D_yu; zeros(m, p), eye(m), eye(m)]);
end

function continuous(file, g)
  m = columns(g.B_u);
  n = rows(g.A);
  w = 1:columns(g.B_w);
  v = columns(g.B_w) + (1:m);
  C = stress_law(g);
  T = lft(generalised_plant(g, n), C, m, m);
  T_feedback = lft(generalised_plant(g, n - g.n_exogenous), C, m, m);
  put(file, "poles", pole(T_feedback));
  put(file, "values_open", sigma(ss(g.A, g.B_w, g.C_y, g.D_yw), g.omega(:)'));
  put(file, "values_closed", sigma(T(:, w), g.omega(:)'));
  put(file, "values_noise", sigma(T(:, v), g.omega(:)'));
end

% The design model, M e'' + K e = -u, sigma = K e + u.
function design(file, g)
  m = rows(g.M);
  legs = ss([zeros(m), eye(m); -(g.M \ g.K), zeros(m)], [zeros(m); -inv(g.M)], ...
            [g.K, zeros(m)], eye(m));
  put(file, "design_poles", pole(feedback(legs, stress_law(g), +1)));
end

% -- Zero-order hold -------------------------------------------------------------------------------

% c2d does not scale the states first: metres beside newtons cost it half of its digits. Balancing
% is by powers of two, which is exact.
function held = zero_order_hold(sys, T)
  [S, ~] = balance(sys.a, "noperm");
  held = ss2ss(c2d(ss2ss(sys, inv(S)), T, "zoh"), S);
end

% -- Sampled loop ----------------------------------------------------------------------------------

function sys = gain(D, T)
  sys = ss(zeros(0), zeros(0, columns(D)), zeros(rows(D), 0), D, T);
end

% One signal for every entry of samples, late by that many.
function sys = delay(samples, T)
  for i = 1:numel(samples)
    one{i} = gain(1, T);
    for k = 1:samples(i)
      one{i} = one{i} * ss(0, 1, 1, 0, T);
    end
  end
  sys = append(one{:});
end

% Inputs (w, c) and outputs (integral of y, sigma, force of the actuators before its gain); states
% of the actuators, the filters, the plant and the integrators.
function sys = with_instruments(g)
  m = columns(g.B_u);
  p = columns(g.B_w);
  n_y = rows(g.C_y);
  if g.lag > 0, actuators = low_pass(g.lag, 0, m); else, actuators = ss(eye(m)); end
  if g.filter > 0, filters = low_pass(g.filter, 0, m); else, filters = ss(eye(m)); end
  plant = ss(g.A, [g.B_w, g.B_u], [g.C_y; g.C_sigma], ...
             [g.D_yw, g.D_yu; zeros(m, p), eye(m)]);
  integrators = ss(zeros(n_y), eye(n_y), eye(n_y), zeros(n_y));
  all = append(actuators, filters, plant, integrators);
  [in_filter, in_u, in_y] = deal(m + (1:m), 2 * m + p + (1:m), 3 * m + p + (1:n_y));
  [out_force, out_y, out_sigma] = deal(1:m, 2 * m + (1:n_y), 2 * m + n_y + (1:m));
  M = zeros(3 * m + p + n_y, 3 * m + 2 * n_y);
  M(in_u, out_force) = diag(g.gains);
  M(in_filter, out_sigma) = eye(m);
  M(in_y, out_y) = eye(n_y);
  sys = mconnect(all, M, [2 * m + (1:p), 1:m], [3 * m + n_y + (1:n_y), m + (1:m), out_force]);
end

% The sampled plant from (w, c_0, c_1) to (mean of y, sigma, report): c_0 acts until a fraction phi
% of the sample has passed, then c_1; sigma and report are read at its beginning.
function P = sampled_plant(g)
  m = columns(g.B_u);
  p = columns(g.B_w);
  n_y = rows(g.C_y);
  T = g.sample_time;
  sys = with_instruments(g);
  n = rows(sys.a) - n_y;
  w = 1:p;
  c = p + (1:m);
  whole = zero_order_hold(sys, T);
  B = [whole.b(:, w), zeros(n + n_y, m), whole.b(:, c)];
  fractions = g.delays - floor(g.delays);
  for phi = unique(fractions(fractions > 0))'
    legs = find(fractions == phi)';
    before = zero_order_hold(sys, phi * T);
    after = zero_order_hold(sys, (1 - phi) * T);
    B(:, p + legs) = after.a * before.b(:, p + legs);
    B(:, p + m + legs) = after.b(:, p + legs);
  end
  state = 1:n;
  mean_of_y = n + (1:n_y);
  C = sys.c(n_y+1:end, state);  % sigma, force
  D = sys.d(n_y+1:end, c);
  if ! g.measured
    C(m+1:end, :) = 0;
    D(m+1:end, :) = eye(m);
  end
  P = ss(whole.a(state, state), B(state, :), [whole.a(mean_of_y, state) / T; C], ...
         [B(mean_of_y, :) / T; zeros(2 * m, p), D, zeros(2 * m, m)], T);
end

function law = sampled_law(g)
  m = rows(g.K_P);
  T = g.sample_time;
  g.tau = 0;  % of the continuous law alone
  if g.naive, F = rolled_off(-proportional_integral(g), g); else, F = strain_law(g); end
  law = c2d(F, T, "tustin");
  if g.lead > 0
    law = law * ss(zeros(m), eye(m), -g.lead * eye(m), (1 + g.lead) * eye(m), T);
  end
end

% What is taken out of sigma, from the report.
function taken_out = applied_force(g)
  m = rows(g.K_P);
  T = g.sample_time;
  if g.naive
    taken_out = gain(zeros(m), T);
    return;
  end
  taken_out = delay(g.report_age * ones(m, 1), T);
  if g.filter > 0
    held = zero_order_hold(low_pass(g.filter, 0, m), T);  % from what is held after t_k to t_k+1
    taken_out = ss(held.a, held.b, held.c * held.a, held.c * held.b, T) * taken_out;
  end
end

function sampled(file, g)
  m = columns(g.B_u);
  p = columns(g.B_w);
  n_y = rows(g.C_y);
  P = sampled_plant(g);
  [A, B, C, D] = ssdata(P);
  put(file, "Phi", A);
  put(file, "Gamma_w", B(:, 1:p));
  put(file, "Gamma_0", B(:, p + (1:m)));
  put(file, "Gamma_u", B(:, p + m + (1:m)));
  put(file, "C_y", C(1:n_y, :));
  put(file, "D_yw", D(1:n_y, 1:p));
  put(file, "D_0", D(1:n_y, p + (1:m)));
  put(file, "D_yu", D(1:n_y, p + m + (1:m)));
  put(file, "C_sigma", C(n_y + (1:m), :));
  put(file, "D_sigma", D(n_y + (1:m), p + (1:m)));
  put(file, "C_report", C(n_y + m + (1:m), :));
  put(file, "D_report", D(n_y + m + (1:m), p + (1:m)));
  law = sampled_law(g);
  put(file, "law_poles", pole(law));
  put(file, "law_response", response(law, g.omega_sampled));

  commands = delay(floor(g.delays), g.sample_time) * law;
  taken_out = applied_force(g);
  held_twice = [delay(ones(m, 1), g.sample_time); gain(eye(m), g.sample_time)];  % (c_0, c_1)
  K = held_twice * commands * [gain(eye(m), g.sample_time), -taken_out];

  % v, the noise of the force sensors, joins as an input of its own.
  noisy = ss(A, [B(:, 1:p), zeros(rows(A), m), B(:, p+1:end)], C, ...
             [D(:, 1:p), [zeros(n_y, m); eye(m); zeros(m)], D(:, p+1:end)], g.sample_time);
  T = lft(noisy, K, 2 * m, 2 * m);
  put(file, "closed_response", response(T(:, 1:p), g.omega_sampled));
  put(file, "noise_response", response(T(:, p + (1:m)), g.omega_sampled));

  n = rows(A) - g.n_exogenous;
  legs = ss(A(1:n, 1:n), B(1:n, p+1:end), C(n_y+1:end, 1:n), D(n_y+1:end, p+1:end), g.sample_time);
  without_floor = ss(legs.a, noisy.b(1:n, p+1:end), C(:, 1:n), noisy.d(:, p+1:end), g.sample_time);
  put(file, "radius", max(abs(pole(lft(without_floor, K, 2 * m, 2 * m)))));
  acts = legs * held_twice;  % from a command to what it does to sigma and report
  L = -feedback(commands, taken_out * acts(m + (1:m), :)) * acts(1:m, :);
  put(file, "return_ratio", response(L, g.omega_sampled));
end

% -- Systems without a loop ------------------------------------------------------------------------

function open_system(file, g)
  sys = ss(g.A, g.B, g.C, g.D);
  n = rows(g.A_q);
  put(file, "poles", pole(ss(g.A_q, zeros(n, 1), zeros(1, n), 0)));
  put(file, "values", sigma(sys, g.omega(:)'));
  held = zero_order_hold(sys, g.sample_time);
  put(file, "Phi", held.a);
  put(file, "Gamma", held.b);
end

% -- Riccati equations -----------------------------------------------------------------------------

function riccati(file, g)
  [X, L, K] = dare(g.A, g.B, g.Q, g.R, g.S);
  put(file, "X", X);
  put(file, "K", K);
end

% -- All cases -------------------------------------------------------------------------------------

folder = argv(){1};
for found = glob(fullfile(folder, "*.given"))'
  given = load("-text", found{1});
  file = fopen(strrep(found{1}, ".given", ".answer"), "w");
  if isfield(given, "K_P")
    continuous(file, given);
    sampled(file, given);
    if isfield(given, "M"), design(file, given); end
  elseif isfield(given, "Q")
    riccati(file, given);
  else
    open_system(file, given);
  end
  fclose(file);
end
