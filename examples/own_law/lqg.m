% A law of one's own, from the model that `stillframe design SCENE --mat loop.mat` writes:
%   octave-cli lqg.m loop.mat law.mat
% makes an LQG regulator that hears sigma, the applied forces and the floor, for `law: law.mat`. It weighs what the outputs
% are accelerated against what the legs are strained, as a mass on a spring of TARGET Hz would.
pkg load control
given = argv ();
loop = load (given{1});
plant = loop.sampled_plant;
target_hz = 5;
if (numel (given) > 2) target_hz = str2double (given{3}); end

is = @(names, what) find (strncmp (names, what, numel (what)));
u = is (plant.input_names, "force:");
w = setdiff (1:numel (plant.input_names), u)';
sigma = is (plant.output_names, "sigma:");
applied = is (plant.output_names, "applied:");
heard = [sigma; applied; is(plant.output_names, "floor:")];
y = setdiff (1:numel (plant.output_names), heard)';

% States in units of their own size, or the Riccati equations see rounding: the largest that they are in an impulse of the
% floor or of the forces.
n = rows (plant.A);
x = [plant.B(:,w), plant.B(:,u)];
largest = max (abs (x), [], 2);
per_force = 0;                                     % m/s^2 per N
for k = 1:200
  x = plant.A * x;
  largest = max (largest, max (abs (x), [], 2));
  per_force = max (per_force, norm (plant.C(y,:) * x(:,numel (w)+1:end)));
end
largest(largest == 0) = 1;
S = diag (largest);
A = S \ plant.A * S;  B = S \ plant.B;  C = plant.C * S;

% y^2 + omega^4 e^2 + a little u^2, e how far the legs are strained. What a floor that is pushed for ever strains them by
% is stiffness over omega_1^2 for the slowest mode, which tells the stiffness of the legs.
poles = log (eig (plant.A)) / plant.Ts;
omega_1 = min (abs (imag (poles(imag (poles) > 0 & isfinite (poles)))));
strain = C(sigma,:) - C(applied,:);
stiff = strain / (eye (n) - A) * B(:,w);
e = strain / max (svd (stiff));
Q = C(y,:)' * C(y,:) + (2 * pi * target_hz / omega_1)^4 * (e' * e);
R = 1e-4 * per_force ^ 2 * eye (numel (u));
K = dlqr (A, B(:,u), Q, R);

% The floor is shaken by 1 m/s^2, sensors by a thousandth of what that does.
noise = [1e-3 * norm(stiff) * ones(numel (sigma) + numel (applied), 1); 1e-2 * ones(numel (w), 1)];
M = dlqe (A, B(:,w), C(heard,:), eye (numel (w)), diag (noise .^ 2));

rest = eye (n) - M * C(heard,:);
law.A = (A - B(:,u) * K) * rest;
law.B = (A - B(:,u) * K) * M;
law.C = -K * rest;
law.D = -K * M;
law.Ts = plant.Ts;
law.input_names = plant.output_names(heard);
law.output_names = plant.input_names(u);
printf ("%d states; largest modulus of the law %.4f, of the loop %.6f\n", n, max (abs (eig (law.A))), ...
        max (abs (eig ([A + B(:,u)*law.D*C(heard,:), B(:,u)*law.C; law.B*C(heard,:), law.A]))));
save ("-v7", given{2}, "law");
